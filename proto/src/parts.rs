//! Payloads that are larger than a message: cut into parts, and put together again.

use bytes::{Bytes, BytesMut};

use crate::FieldError;

/// Bytes of a full part. A gRPC message may hold 4 MiB; small parts keep the buffers of
/// slow readers small, and cost nothing beside the payload.
pub const PART_BYTES: usize = 64 << 10;

/// Cuts a payload into parts of at most [`PART_BYTES`], each with its position in the
/// payload. An empty payload is one empty part, so that its receiver hears of it.
pub fn split(payload: &Bytes) -> impl Iterator<Item = (u64, Bytes)> + use<> {
    let payload = payload.clone();
    let parts = payload.len().div_ceil(PART_BYTES).max(1);
    (0..parts).map(move |part| {
        let start = part * PART_BYTES;
        let end = payload.len().min(start + PART_BYTES);
        (start as u64, payload.slice(start..end))
    })
}

/// A payload that is being received in parts.
#[derive(Debug)]
pub struct Assembly {
    total: usize,
    bytes: BytesMut,
}

impl Assembly {
    /// Begins a payload of `total_bytes`; refused above `limit`. Memory is taken as parts
    /// arrive, not on the sender's word.
    pub fn new(total_bytes: u64, limit: u64) -> Result<Self, FieldError> {
        let total = usize::try_from(total_bytes).ok().filter(|_| total_bytes <= limit);
        let total = total.ok_or_else(|| {
            FieldError::new("total_bytes", format!("is {total_bytes}, at most {limit} are taken"))
        })?;
        Ok(Self { total, bytes: BytesMut::new() })
    }

    /// Adds the next part; gives the payload once it is whole.
    pub fn push(
        &mut self,
        total_bytes: u64,
        offset: u64,
        data: &[u8],
    ) -> Result<Option<Bytes>, FieldError> {
        if total_bytes != self.total as u64 {
            return Err(FieldError::new(
                "total_bytes",
                format!("is {total_bytes}, was {} in the part before", self.total),
            ));
        }
        if offset != self.bytes.len() as u64 {
            return Err(FieldError::new(
                "offset",
                format!("is {offset}, must be {}, where the part before ended", self.bytes.len()),
            ));
        }
        if data.len() > self.total - self.bytes.len() {
            return Err(FieldError::new(
                "data",
                format!(
                    "holds {} bytes at {offset}, beyond the total of {}",
                    data.len(),
                    self.total
                ),
            ));
        }
        if data.is_empty() && self.total != 0 {
            return Err(FieldError::new("data", "is empty"));
        }
        self.bytes.extend_from_slice(data);
        Ok((self.bytes.len() == self.total).then(|| std::mem::take(&mut self.bytes).freeze()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn payloads_of_every_size_come_back() {
        for size in [0, 1, PART_BYTES - 1, PART_BYTES, PART_BYTES + 1, 3 * PART_BYTES + 7] {
            let payload: Bytes = (0..size).map(|i| (i % 251) as u8).collect();
            let mut assembly = Assembly::new(size as u64, 1 << 30).expect("small");
            let mut whole = None;
            for (offset, part) in split(&payload) {
                assert!(whole.is_none() && part.len() <= PART_BYTES);
                whole = assembly.push(size as u64, offset, &part).expect("in order");
            }
            assert!(whole == Some(payload), "{size}");
        }
    }

    #[test]
    fn parts_that_do_not_fit_are_named() {
        assert_eq!(Assembly::new(u64::MAX, 1 << 20).expect_err("huge").field, "total_bytes");
        let mut assembly = Assembly::new(4, 4).expect("small");
        assert_eq!(assembly.push(5, 0, b"ab").expect_err("total").field, "total_bytes");
        assert_eq!(assembly.push(4, 1, b"ab").expect_err("gap").field, "offset");
        assert_eq!(assembly.push(4, 0, b"abcde").expect_err("too long").field, "data");
        assert_eq!(assembly.push(4, 0, b"").expect_err("no progress").field, "data");
        assert_eq!(assembly.push(4, 0, b"ab"), Ok(None));
        assert_eq!(assembly.push(4, 0, b"ab").expect_err("again").field, "offset");
        assert_eq!(assembly.push(4, 2, b"cd"), Ok(Some(Bytes::from_static(b"abcd"))));
    }
}

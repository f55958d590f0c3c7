//! Variable length records of a LAS file.

use std::path::PathBuf;

/// A record of at most 65 535 bytes, before the points.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Vlr {
    /// Who defined the record, padded with zeros.
    pub user_id: [u8; 16],
    /// Which of that user's records it is.
    pub record_id: u16,
    /// Free text, padded with zeros.
    pub description: [u8; 32],
    /// Its content.
    pub data: Vec<u8>,
}

/// A record behind the points, of any length: its content stays in the file it came from.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Evlr {
    /// Who defined the record, padded with zeros.
    pub user_id: [u8; 16],
    /// Which of that user's records it is.
    pub record_id: u16,
    /// Free text, padded with zeros.
    pub description: [u8; 32],
    /// The file that holds the content.
    pub file: PathBuf,
    /// Where in that file the content begins, bytes.
    pub offset: u64,
    /// Length of the content, bytes.
    pub length: u64,
}

impl Vlr {
    /// Bytes of the header before the content.
    pub const HEADER_LENGTH: u64 = 54;

    /// A record with texts cut to their fields.
    pub fn new(user_id: &str, record_id: u16, description: &str, data: Vec<u8>) -> Self {
        Self { user_id: padded(user_id), record_id, description: padded(description), data }
    }

    /// Whether this is that record of that user.
    pub fn is(&self, user_id: &str, record_id: u16) -> bool {
        self.record_id == record_id && self.user_id == padded(user_id)
    }

    /// The record as it stands in a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let length = u16::try_from(self.data.len()).expect("a VLR is read or made below 64 KiB");
        let mut bytes = Vec::with_capacity(self.data.len() + 54);
        bytes.extend([0; 2]);
        bytes.extend(self.user_id);
        bytes.extend(self.record_id.to_le_bytes());
        bytes.extend(length.to_le_bytes());
        bytes.extend(self.description);
        bytes.extend(&self.data);
        bytes
    }
}

impl Evlr {
    /// Bytes of the header before the content.
    pub const HEADER_LENGTH: u64 = 60;

    /// Whether this is that record of that user.
    pub fn is(&self, user_id: &str, record_id: u16) -> bool {
        self.record_id == record_id && self.user_id == padded(user_id)
    }

    /// The header of a record with this content length.
    pub(super) fn header_bytes(
        user_id: [u8; 16],
        record_id: u16,
        description: [u8; 32],
        length: u64,
    ) -> Vec<u8> {
        let mut bytes = vec![0; 2];
        bytes.extend(user_id);
        bytes.extend(record_id.to_le_bytes());
        bytes.extend(length.to_le_bytes());
        bytes.extend(description);
        bytes
    }
}

/// Text in a field of fixed size, cut or filled with zeros.
pub(super) fn padded<const N: usize>(text: &str) -> [u8; N] {
    let mut field = [0; N];
    let length = text.len().min(N);
    field[..length].copy_from_slice(&text.as_bytes()[..length]);
    field
}

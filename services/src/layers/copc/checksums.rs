//! The record, of our own, with the checksums of a COPC file's chunks.
//!
//! It comes right behind the hierarchy and is laid out in step with it: for each 32 bytes of
//! the hierarchy, an entry, four bytes here: the CRC-32 of the node's chunk, little-endian, 0
//! for entries without a chunk. So the checksums of a page lie together, and are found from
//! where the page lies. Other readers of COPC pass over records that they do not know.

use std::ops::Range;

use super::hierarchy::ENTRY_BYTES;
use super::read::PageAddress;
use super::vlr::{Evlr, padded};

/// Bytes of a checksum.
pub(super) const CHECKSUM_BYTES: u64 = 4;

const USER_ID: &str = "flaneur";
const RECORD_ID: u16 = 1;

/// Whether this is the record. It does not hold for points that are stored anew.
pub(crate) fn is_checksums(evlr: &Evlr) -> bool {
    evlr.is(USER_ID, RECORD_ID)
}

/// The record's header where it holds `length` bytes.
pub(super) fn header_bytes(length: u64) -> Vec<u8> {
    Evlr::header_bytes(padded(USER_ID), RECORD_ID, padded("CRC-32 of the chunks"), length)
}

/// Where hierarchy and checksums lie in a file.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// The hierarchy without its header; whole entries.
    pages: Range<u64>,
}

impl Layout {
    /// From the header of the hierarchy's record, at byte `start` of a file of `size` bytes; or
    /// what is wrong with it.
    pub(super) fn of_hierarchy(
        start: u64,
        header: &[u8; Evlr::HEADER_LENGTH as usize],
        size: u64,
    ) -> Result<Self, String> {
        if header[2..18] != padded::<16>("copc") || header[18..20] != 1000_u16.to_le_bytes() {
            return Err("the first record behind the points is not COPC's hierarchy".to_owned());
        }
        let length = u64::from_le_bytes(std::array::from_fn(|i| header[20 + i]));
        let begin = start.saturating_add(Evlr::HEADER_LENGTH);
        let layout = Self { pages: begin..begin.saturating_add(length) };
        let end = layout.checksums_start().saturating_add(layout.checksum_bytes());
        if !length.is_multiple_of(ENTRY_BYTES) || end > size {
            return Err(format!(
                "a hierarchy of {length} bytes and its checksums do not fit in {size}"
            ));
        }
        Ok(layout)
    }

    /// Where the header of the checksums' record lies.
    pub(super) fn header(&self) -> Range<u64> {
        self.pages.end..self.pages.end.saturating_add(Evlr::HEADER_LENGTH)
    }

    /// Whether these bytes, of [`Layout::header`], are such a header.
    pub(super) fn is_header(&self, header: &[u8]) -> bool {
        header.get(2..) == header_bytes(self.checksum_bytes()).get(2..)
    }

    /// Where the checksums of a page's entries lie; `None` where the page is not one of the
    /// hierarchy's.
    pub(super) fn of_page(&self, page: &PageAddress) -> Option<Range<u64>> {
        let begin = page.offset.checked_sub(self.pages.start)?;
        let end = begin.checked_add(u64::from(page.byte_size))?;
        let inside = begin.is_multiple_of(ENTRY_BYTES)
            && end.is_multiple_of(ENTRY_BYTES)
            && end <= self.pages.end - self.pages.start;
        let place = |entry: u64| self.checksums_start() + entry / ENTRY_BYTES * CHECKSUM_BYTES;
        inside.then(|| place(begin)..place(end))
    }

    fn checksums_start(&self) -> u64 {
        self.header().end
    }

    fn checksum_bytes(&self) -> u64 {
        (self.pages.end - self.pages.start) / ENTRY_BYTES * CHECKSUM_BYTES
    }
}

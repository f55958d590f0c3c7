//! Reads the hierarchy of a COPC object by ranges, without trust: every size is checked
//! against the object before memory is taken, and every page lies deeper than the page that
//! leads to it, so that no chain of pages is endless.

use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use flaneur_scene::NodeKey;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};

use super::checksums::Layout;
use super::vlr::Evlr;
use crate::layers::LayerError;

/// A COPC object of a store, its header read and checked.
#[derive(Clone, Debug)]
pub struct CopcFile {
    store: Arc<dyn ObjectStore>,
    path: Path,
    size: u64,
    root: PageAddress,
    layout: Layout,
}

/// Where a page of the hierarchy lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PageAddress {
    /// Root of the subtree that the page describes.
    pub key: NodeKey,
    /// Its first byte in the file.
    pub offset: u64,
    /// Its length; whole entries.
    pub byte_size: u32,
}

/// A page of the hierarchy: the nodes near its root, and the pages that say more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// Where it lies.
    pub address: PageAddress,
    /// What it lists, in the order of the keys: coarse levels first.
    pub entries: Vec<PageEntry>,
}

/// An entry of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageEntry {
    /// Which node.
    pub key: NodeKey,
    /// What the page knows of it.
    pub item: PageItem,
}

/// What a page knows of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PageItem {
    /// A node with its chunk.
    Node {
        /// Its first byte in the file.
        offset: u64,
        /// Its length.
        byte_size: u32,
        /// Its points; 0 where the node only leads on.
        point_count: u32,
        /// CRC-32 of its chunk.
        crc32: u32,
    },
    /// The root of another page.
    Page(PageAddress),
}

/// LAS 1.4 header, header of the first variable length record, and its COPC information.
const HEADER_BYTES: u64 = 375 + 54 + 160;

/// Bytes of an entry of a page.
const ENTRY_BYTES: usize = super::hierarchy::ENTRY_BYTES as usize;

/// Largest page that is read: half a million nodes.
const MAX_PAGE_BYTES: u32 = 16 << 20;

impl CopcFile {
    /// Opens `path`, of `size` bytes, reading nothing but headers.
    pub async fn open(
        store: Arc<dyn ObjectStore>,
        path: Path,
        size: u64,
    ) -> Result<Self, LayerError> {
        let damaged = |offset, problem: String| LayerError::at_byte(&path, offset, problem);
        if size < HEADER_BYTES {
            return Err(damaged(0, format!("{size} bytes are no COPC file")));
        }
        let header = store.get_range(&path, 0..HEADER_BYTES).await?;
        let (offset, byte_size) = root_page(&header).map_err(|(at, what)| damaged(at, what))?;
        let root = PageAddress { key: NodeKey::ROOT, offset, byte_size };
        let start = header.get(235..243).and_then(|at| at.first_chunk());
        let start = start.map_or(0, |at| u64::from_le_bytes(*at));
        let layout = layout(&store, &path, start, size).await?;
        let file = Self { store, path, size, root, layout };
        file.check_page(&root, 375 + 54)?;
        Ok(file)
    }

    /// The page that everything hangs on.
    pub fn root(&self) -> PageAddress {
        self.root
    }

    /// Bytes of the file: more than this, its pages cannot hold together.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Reads a page.
    pub async fn page(&self, address: PageAddress) -> Result<Page, LayerError> {
        self.check_page(&address, address.offset)?;
        let place = address.offset..address.offset + u64::from(address.byte_size);
        let sums = self.layout.of_page(&address).ok_or_else(|| {
            self.damaged(address.offset, "the page lies outside of the hierarchy".to_owned())
        })?;
        let ranges = [place, sums];
        let read = self.store.get_ranges(&self.path, &ranges).await?;
        let [page, sums] = read.as_slice() else {
            return Err(self.damaged(address.offset, "the store gave no ranges".to_owned()));
        };
        for (range, bytes) in ranges.iter().zip([page, sums]) {
            self.check_length(range, bytes)?;
        }
        let mut entries = Vec::with_capacity(page.len() / ENTRY_BYTES);
        let (records, sums) = (page.as_chunks::<ENTRY_BYTES>().0, sums.as_chunks::<4>().0);
        let places = (address.offset..).step_by(ENTRY_BYTES);
        for ((record, sum), at) in records.iter().zip(sums).zip(places) {
            entries.push(self.entry(record, u32::from_le_bytes(*sum), at, &address)?);
        }
        entries.sort_unstable_by_key(|entry| entry.key);
        if let Some(pair) = entries.windows(2).find(|pair| pair[0].key == pair[1].key) {
            let problem = format!("the page lists {:?} twice", pair[0].key);
            return Err(self.damaged(address.offset, problem));
        }
        Ok(Page { address, entries })
    }

    /// Bytes of the file, as many as asked for.
    pub async fn get(&self, range: Range<u64>) -> Result<Bytes, LayerError> {
        let bytes = self.store.get_range(&self.path, range.clone()).await?;
        self.check_length(&range, &bytes)?;
        Ok(bytes)
    }

    fn check_length(&self, range: &Range<u64>, bytes: &Bytes) -> Result<(), LayerError> {
        if bytes.len() as u64 == range.end - range.start {
            return Ok(());
        }
        let problem = format!("the store gave {} bytes of {range:?}", bytes.len());
        Err(self.damaged(range.start, problem))
    }

    fn entry(
        &self,
        record: &[u8; ENTRY_BYTES],
        crc32: u32,
        at: u64,
        page: &PageAddress,
    ) -> Result<PageEntry, LayerError> {
        let damaged = |problem: String| self.damaged(at, problem);
        let [level, x, y, z] = [0, 4, 8, 12].map(|start| int(record, start));
        let (offset, byte_size) = (long(record, 16), int(record, 24));
        let key = NodeKey::new_checked(level, x, y, z)
            .filter(|key| is_below(*key, page.key))
            .ok_or_else(|| {
                damaged(format!("{level}-{x}-{y}-{z} is no node below {:?}", page.key))
            })?;
        let fits = |byte_size: u32| {
            offset.checked_add(u64::from(byte_size)).is_some_and(|end| end <= self.size)
        };
        let item = match int(record, 28).cast_signed() {
            -1 => {
                let next = PageAddress { key, offset, byte_size };
                self.check_page(&next, at)?;
                if key.level <= page.key.level {
                    return Err(damaged(format!("the page of {key:?} leads back to itself")));
                }
                PageItem::Page(next)
            }
            count if count >= 0 => {
                let point_count = count.unsigned_abs();
                if !fits(byte_size) || (point_count == 0) != (byte_size == 0) {
                    return Err(damaged(format!(
                        "{key:?} has {point_count} points in {byte_size} bytes at {offset} of {}",
                        self.size
                    )));
                }
                PageItem::Node { offset, byte_size, point_count, crc32 }
            }
            count => return Err(damaged(format!("{key:?} has {count} points"))),
        };
        Ok(PageEntry { key, item })
    }

    fn check_page(&self, page: &PageAddress, at: u64) -> Result<(), LayerError> {
        let PageAddress { key, offset, byte_size } = *page;
        let within = offset.checked_add(u64::from(byte_size)).is_some_and(|end| end <= self.size);
        let whole = byte_size > 0 && byte_size.is_multiple_of(ENTRY_BYTES as u32);
        if !within || !whole || byte_size > MAX_PAGE_BYTES {
            let problem = format!(
                "the page of {key:?} is said to have {byte_size} bytes at {offset} of {}, must be \
                 whole entries of {ENTRY_BYTES} bytes, {MAX_PAGE_BYTES} at most",
                self.size
            );
            return Err(self.damaged(at, problem));
        }
        Ok(())
    }

    fn damaged(&self, offset: u64, problem: String) -> LayerError {
        LayerError::at_byte(&self.path, offset, problem)
    }
}

impl Page {
    /// The entry of a node.
    pub fn entry(&self, key: NodeKey) -> Option<&PageEntry> {
        let index = self.entries.binary_search_by_key(&key, |entry| entry.key).ok()?;
        self.entries.get(index)
    }

    /// The page, listed here, in which `key` or a node above it is found.
    pub fn towards(&self, key: NodeKey) -> Option<PageAddress> {
        let mut above = Some(key);
        while let Some(key) = above.filter(|key| key.level > self.address.key.level) {
            if let Some(PageEntry { item: PageItem::Page(page), .. }) = self.entry(key) {
                return Some(*page);
            }
            above = key.parent();
        }
        None
    }
}

/// Whether `key` is `root` or lies below it.
fn is_below(key: NodeKey, root: NodeKey) -> bool {
    key.level.checked_sub(root.level).is_some_and(|depth| {
        (key.x >> depth, key.y >> depth, key.z >> depth) == (root.x, root.y, root.z)
    })
}

/// Where the hierarchy and its checksums lie, whose records begin at `start`.
async fn layout(
    store: &Arc<dyn ObjectStore>,
    path: &Path,
    start: u64,
    size: u64,
) -> Result<Layout, LayerError> {
    let damaged = |at, problem: String| LayerError::at_byte(path, at, problem);
    let end = start.checked_add(Evlr::HEADER_LENGTH).filter(|end| *end <= size);
    let end = end.ok_or_else(|| damaged(235, format!("no records at {start} of {size}")))?;
    let header = store.get_range(path, start..end).await?;
    let layout = match header.as_ref().try_into() {
        Ok(header) => Layout::of_hierarchy(start, header, size),
        Err(_) => Err(format!("the store gave {} bytes of a header", header.len())),
    };
    let layout = layout.map_err(|problem| damaged(start, problem))?;
    let place = layout.header();
    if !layout.is_header(&store.get_range(path, place.clone()).await?) {
        let problem = "no checksums follow the hierarchy; ingest the survey again";
        return Err(damaged(place.start, problem.to_owned()));
    }
    Ok(layout)
}

/// Offset and size of the root page, out of the file's first [`HEADER_BYTES`]; or where and
/// why they are no COPC header.
fn root_page(header: &[u8]) -> Result<(u64, u32), (u64, String)> {
    let header: &[u8; HEADER_BYTES as usize] =
        header.try_into().map_err(|_| (0, format!("the header has {} bytes", header.len())))?;
    if !header.starts_with(b"LASF") || header[24..26] != [1, 4] {
        return Err((0, "no LAS 1.4 file".to_owned()));
    }
    // The COPC record must be the first: user id at 2 of its header, record id at 18.
    if &header[377..382] != b"copc\0" || header[393..395] != [1, 0] {
        return Err((377, "the first record is not COPC's".to_owned()));
    }
    let (offset, byte_size) = (long(header, 469), long(header, 477));
    let byte_size = u32::try_from(byte_size)
        .map_err(|_| (477, format!("the root page is said to have {byte_size} bytes")))?;
    Ok((offset, byte_size))
}

/// A little-endian integer inside of a record; `start` is a constant of the format.
fn int<const N: usize>(record: &[u8; N], start: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| record[start + i]))
}

/// Like [`int`], of eight bytes.
fn long<const N: usize>(record: &[u8; N], start: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| record[start + i]))
}

#[cfg(test)]
pub(super) mod tests;

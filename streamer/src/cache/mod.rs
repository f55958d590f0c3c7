//! Payloads as they arrived, so that what was fetched once need not be fetched again.
//!
//! What is kept are the stored forms: compressed points, pictures, masks, encoded answers about
//! a region. They are 5 to 10 times smaller than what they decode to, and decoding takes
//! milliseconds. Memory is asked first, then a folder, which outlives the process:
//!
//! | file | what |
//! |---|---|
//! | `key.rs` | the name of a payload |
//! | `segmented.rs` | which entries stay: a least-recently-used list in two segments, by bytes |
//! | `memory.rs` | payloads in memory |
//! | `working_set.rs` | what the views of those who share the cache ask for |
//! | `disk/` | payloads in a folder, checked when read, bounded, shared by processes |
//!
//! The caller checks what it inserts. What is found is checked again against what the caller
//! expects of it: an entry that differs is removed and counts as absent.

mod disk;
mod key;
mod memory;
mod segmented;
mod statistics;
mod working_set;

#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use bytes::Bytes;
use flaneur_scene::{Node, StoredImage};

pub(crate) use key::CacheKey;
pub use segmented::{Rank, SegmentedLru};
pub use statistics::CacheStatistics;
pub(crate) use working_set::WorkingSet;

use disk::Disk;
use memory::Memory;
use statistics::Counts;

/// How much is kept, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CacheOptions {
    /// Bytes of payloads in memory, their bookkeeping included; 0 keeps none.
    pub memory_bytes: u64,
    /// The part that outlives the process.
    pub disk: Option<DiskOptions>,
}

/// A folder for payloads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiskOptions {
    /// A folder, made where it is missing. Only a folder of the cache's own within it is touched, and
    /// several processes may use it at once.
    pub folder: PathBuf,
    /// Bytes that all files together may take, counted in blocks of 4 KiB.
    pub bytes: u64,
}

/// Why a cache cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
pub enum CacheError {
    /// The place is taken by something else.
    #[error(
        "the cache's folder is not a folder but a file; name another, or remove it: {}",
        folder.display()
    )]
    NotAFolder {
        /// What was given.
        folder: PathBuf,
    },
}

/// What is known of a payload before it is read: from a hierarchy or a manifest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Checked {
    /// Its length, bytes.
    pub(crate) length: u64,
    /// The CRC-32 (IEEE 802.3) of its bytes.
    pub(crate) crc32: u32,
}

impl From<StoredImage> for Checked {
    fn from(image: StoredImage) -> Self {
        Self { length: image.bytes, crc32: image.crc32 }
    }
}

impl From<Node> for Checked {
    fn from(node: Node) -> Self {
        Self { length: node.byte_size.into(), crc32: node.crc32 }
    }
}

impl Checked {
    /// What holds of `payload`.
    pub(crate) fn of(payload: &[u8]) -> Self {
        Self { length: payload.len() as u64, crc32: crc32fast::hash(payload) }
    }

    /// Whether `payload` is what was expected. About 0.1 ms a megabyte.
    pub(crate) fn holds(&self, payload: &[u8]) -> bool {
        // The length first: it costs nothing.
        self.length == payload.len() as u64 && *self == Self::of(payload)
    }
}

/// The cache of one program. All methods take `&self` and may be called from anywhere.
#[derive(Debug)]
pub(crate) struct Cache {
    memory: Arc<Memory>,
    disk: Option<Arc<Disk>>,
    counts: Arc<Counts>,
}

impl Cache {
    /// An empty memory, and what the folder holds.
    ///
    /// A folder that cannot be written, or a full disk, is no error: one warning is logged,
    /// and what can be read is still used.
    ///
    /// # Errors
    /// Where the folder's name is that of a file.
    pub(crate) fn new(options: &CacheOptions) -> Result<Self, CacheError> {
        let counts = Arc::<Counts>::default();
        let disk = match &options.disk {
            Some(disk) => Disk::open(disk, Arc::clone(&counts))?.map(Arc::new),
            None => None,
        };
        Ok(Self { memory: Arc::new(Memory::new(options.memory_bytes)), disk, counts })
    }

    /// The payload of `key`, where it is held and is what is `expected`. What is found on disk is
    /// kept in memory from then on. Must be called within a tokio runtime, on whose blocking
    /// threads files are read.
    pub(crate) async fn get(&self, key: &CacheKey, expected: Option<Checked>) -> Option<Bytes> {
        if let Some(payload) = self.memory.get(key) {
            if expected.is_none_or(|expected| expected.holds(&payload)) {
                self.counts.memory_hits.fetch_add(1, Relaxed);
                return Some(payload);
            }
            self.memory.remove(key);
            self.counts.damaged.fetch_add(1, Relaxed);
        }
        if let Some(disk) = &self.disk
            && let Some((payload, rank)) = disk.get(key, expected).await
        {
            self.counts.disk_hits.fetch_add(1, Relaxed);
            self.memory.insert(key, payload.clone(), rank);
            return Some(payload);
        }
        self.counts.misses.fetch_add(1, Relaxed);
        None
    }

    /// What memory holds of `key`, unchecked and uncounted.
    pub(crate) fn at_hand(&self, key: &CacheKey) -> Option<Bytes> {
        self.memory.get(key)
    }

    /// Keeps `payload`, as far as there is room. It is written to disk behind; where more waits to be
    /// written than memory should hold, it is kept in memory alone.
    ///
    /// A payload counts with its length: it should own its allocation, not be a piece of a
    /// larger one.
    pub(crate) fn insert(&self, key: &CacheKey, payload: Bytes, rank: Rank) {
        if let Some(disk) = &self.disk {
            disk.insert(key, payload.clone(), rank);
        }
        self.memory.insert(key, payload, rank);
    }

    /// Forgets `key`, wherever it is held: its bytes turned out to be of no use.
    pub(crate) fn remove(&self, key: &CacheKey) {
        self.memory.remove(key);
        if let Some(disk) = &self.disk {
            disk.remove(key);
        }
    }

    /// The place of one who asks the cache for what views want.
    pub(crate) fn working_set(&self) -> WorkingSet {
        WorkingSet::new(Arc::clone(&self.memory))
    }

    /// Returns once everything that was inserted before is on disk, or will not be.
    pub(crate) async fn flush(&self) {
        if let Some(disk) = &self.disk {
            disk.flush().await;
        }
    }

    /// What has happened so far.
    pub(crate) fn statistics(&self) -> CacheStatistics {
        let (memory_bytes, evicted) = self.memory.held();
        self.counts.snapshot(memory_bytes, evicted)
    }
}

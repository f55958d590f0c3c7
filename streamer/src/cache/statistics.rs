//! What a cache has done.

use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

/// Counts of one cache since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheStatistics {
    /// Payloads found in memory.
    pub memory_hits: u64,
    /// Payloads found on disk.
    pub disk_hits: u64,
    /// Payloads found nowhere.
    pub misses: u64,
    /// Bytes held in memory, with their bookkeeping.
    pub memory_bytes: u64,
    /// Bytes of the folder's files, in blocks, when it was last written to.
    pub disk_bytes: u64,
    /// Payloads that made room for others in memory.
    pub evicted: u64,
    /// Entries that were not what they should have been, and were removed.
    pub damaged: u64,
    /// Payloads that were not written to disk: too much was waiting, or writing had failed.
    pub not_written: u64,
}

impl CacheStatistics {
    /// Share of payloads that were found, 0 to 1; 0 where none was asked for.
    pub fn hit_rate(&self) -> f64 {
        let hits = self.memory_hits + self.disk_hits;
        hits as f64 / (hits + self.misses).max(1) as f64
    }
}

/// The counts as they are kept.
#[derive(Debug, Default)]
pub(super) struct Counts {
    pub(super) memory_hits: AtomicU64,
    pub(super) disk_hits: AtomicU64,
    pub(super) misses: AtomicU64,
    pub(super) disk_bytes: AtomicU64,
    pub(super) damaged: AtomicU64,
    pub(super) not_written: AtomicU64,
}

impl Counts {
    pub(super) fn snapshot(&self, memory_bytes: u64, evicted: u64) -> CacheStatistics {
        CacheStatistics {
            memory_hits: self.memory_hits.load(Relaxed),
            disk_hits: self.disk_hits.load(Relaxed),
            misses: self.misses.load(Relaxed),
            memory_bytes,
            disk_bytes: self.disk_bytes.load(Relaxed),
            evicted,
            damaged: self.damaged.load(Relaxed),
            not_written: self.not_written.load(Relaxed),
        }
    }
}

//! Payloads in memory.

use std::sync::{Mutex, MutexGuard, PoisonError};

use bytes::Bytes;

use super::{CacheKey, Rank, SegmentedLru};

/// What an entry takes beside its key and payload: links, hashes, lengths. Counted, so that many
/// small entries are bounded, too.
const ENTRY_BYTES: u64 = 160;

/// Payloads by key. One lock guards them: it is held for well under a microsecond.
#[derive(Debug)]
pub(super) struct Memory {
    entries: Mutex<SegmentedLru<CacheKey, Bytes>>,
}

impl Memory {
    /// An empty memory of at most `bytes`.
    pub(super) fn new(bytes: u64) -> Self {
        Self { entries: Mutex::new(SegmentedLru::new(bytes)) }
    }

    pub(super) fn get(&self, key: &CacheKey) -> Option<Bytes> {
        self.entries().get(key).cloned()
    }

    pub(super) fn insert(&self, key: &CacheKey, payload: Bytes, rank: Rank) {
        let weight = payload.len() as u64 + key.as_str().len() as u64 + ENTRY_BYTES;
        self.entries().insert(key.clone(), payload, weight, rank);
    }

    pub(super) fn remove(&self, key: &CacheKey) {
        self.entries().remove(key);
    }

    pub(super) fn working_set(&self, bytes: u64) {
        self.entries().set_working_set(bytes);
    }

    /// Bytes held, and entries that had to make room so far.
    pub(super) fn held(&self) -> (u64, u64) {
        let entries = self.entries();
        (entries.weight(), entries.evicted())
    }

    fn entries(&self) -> MutexGuard<'_, SegmentedLru<CacheKey, Bytes>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

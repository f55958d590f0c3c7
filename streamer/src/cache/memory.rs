//! Payloads in memory.

use std::collections::BTreeMap;
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
    /// Bytes that views ask for, and how many ask for so many.
    working_sets: Mutex<BTreeMap<u64, usize>>,
}

impl Memory {
    /// An empty memory of at most `bytes`.
    pub(super) fn new(bytes: u64) -> Self {
        Self { entries: Mutex::new(SegmentedLru::new(bytes)), working_sets: Mutex::default() }
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

    /// Someone's view asks for other bytes than before; the most that any does counts.
    pub(super) fn replace_working_set(&self, before: Option<u64>, now: Option<u64>) {
        let mut sets = self.working_sets.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(now) = now {
            *sets.entry(now).or_default() += 1;
        }
        if let Some(before) = before
            && let Some(count) = sets.get_mut(&before)
        {
            *count -= 1;
            if *count == 0 {
                sets.remove(&before);
            }
        }
        let most = sets.last_key_value().map_or(0, |(&bytes, _)| bytes);
        self.entries().set_working_set(most);
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

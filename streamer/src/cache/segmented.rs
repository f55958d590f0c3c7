//! A segmented least-recently-used list, by bytes.
//!
//! Entries begin in *probation*. One that is used again moves to the *protected* segment;
//! what no longer fits there goes back to the front of probation, and what falls out of probation
//! is gone. So what was used twice outlives any number of entries that were used once.
//!
//! That fails when probation holds less than is used between two uses of an entry: nothing is
//! ever used again in time, and nothing is ever promoted. A walk does just that: each view uses all
//! of what it shows, one after the other, and so does the next. Therefore probation
//! has what is free of protection's room, and is never given less than the working set, where that
//! fits at all.

use std::hash::Hash;

use lru::LruCache;

/// Where a new entry begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rank {
    /// A coarse level, on which everything finer is built and to which every view comes back:
    /// protected at once.
    Upper,
    /// Everything else: on probation.
    Detail,
}

/// Values by key, bounded by the sum of their weights.
#[derive(Debug)]
pub struct SegmentedLru<K: Hash + Eq, V> {
    capacity: u64,
    working_set: u64,
    probation: Segment<K, V>,
    protected: Segment<K, V>,
    evicted: u64,
}

impl<K: Hash + Eq, V> SegmentedLru<K, V> {
    /// An empty list of at most `capacity`, in the unit in which entries are weighed.
    pub fn new(capacity: u64) -> Self {
        Self {
            capacity,
            working_set: 0,
            probation: Segment::new(),
            protected: Segment::new(),
            evicted: 0,
        }
    }

    /// The value of `key`, which is promoted.
    pub fn get(&mut self, key: &K) -> Option<&V> {
        let limit = self.protected_limit();
        // In this order the common case, an entry that is protected, costs least.
        if self.protected.entries.promote(key) {
            return self.protected.front();
        }
        if self.probation.entries.get(key)?.weight > limit {
            return self.probation.front();
        }
        let (key, entry) = self.probation.remove(key)?;
        self.protected.push(key, entry);
        self.demote();
        self.protected.front()
    }

    /// Takes a value, in place of what `key` had. One that is heavier than what its segment is
    /// sure to hold is not taken: it would push out a whole view for itself.
    pub fn insert(&mut self, key: K, value: V, weight: u64, rank: Rank) {
        let was_protected = self.protected.remove(&key).is_some();
        self.probation.remove(&key);
        let entry = Entry { value, weight };
        let protect = rank == Rank::Upper || was_protected;
        if protect && weight <= self.protected_limit() {
            self.protected.push(key, entry);
            self.demote();
        } else if weight <= self.capacity - self.protected_limit() {
            self.probation.push(key, entry);
        }
        self.evict();
    }

    /// Drops the entry of `key`.
    pub fn remove(&mut self, key: &K) {
        self.probation.remove(key);
        self.protected.remove(key);
    }

    /// Sets the weight that probation is given at least, where the capacity is as much. Nothing
    /// is dropped.
    pub fn set_working_set(&mut self, weight: u64) {
        self.working_set = weight;
        self.demote();
    }

    /// The weight of all entries: at most the capacity.
    pub fn weight(&self) -> u64 {
        self.probation.weight + self.protected.weight
    }

    /// Entries that had to make room so far.
    pub fn evicted(&self) -> u64 {
        self.evicted
    }

    /// What the protected segment may hold: four fifths, or less where the working set is larger
    /// than the fifth that is left. A working set that does not fit at all would be
    /// gone before it is used again however much it is given: it gets the fifth.
    fn protected_limit(&self) -> u64 {
        let four_fifths = self.capacity - self.capacity.div_ceil(5);
        match self.capacity.checked_sub(self.working_set) {
            Some(rest) => four_fifths.min(rest),
            None => four_fifths,
        }
    }

    fn demote(&mut self) {
        while self.protected.weight > self.protected_limit() {
            let Some((key, entry)) = self.protected.pop() else { break };
            self.probation.push(key, entry);
        }
    }

    fn evict(&mut self) {
        while self.weight() > self.capacity {
            if self.probation.pop().is_none() {
                break;
            }
            self.evicted += 1;
        }
    }
}

#[derive(Debug)]
struct Entry<V> {
    value: V,
    weight: u64,
}

/// Entries, the one used last in front, and the sum of their weights.
#[derive(Debug)]
struct Segment<K: Hash + Eq, V> {
    entries: LruCache<K, Entry<V>>,
    weight: u64,
}

impl<K: Hash + Eq, V> Segment<K, V> {
    fn new() -> Self {
        Self { entries: LruCache::unbounded(), weight: 0 }
    }

    /// Puts an entry in front. Its key must be new here.
    fn push(&mut self, key: K, entry: Entry<V>) {
        self.weight += entry.weight;
        self.entries.push(key, entry);
    }

    /// The value that was used last.
    fn front(&self) -> Option<&V> {
        self.entries.peek_mru().map(|(_, entry)| &entry.value)
    }

    /// Takes the entry that was used longest ago.
    fn pop(&mut self) -> Option<(K, Entry<V>)> {
        let (key, entry) = self.entries.pop_lru()?;
        self.weight -= entry.weight;
        Some((key, entry))
    }

    fn remove(&mut self, key: &K) -> Option<(K, Entry<V>)> {
        let (key, entry) = self.entries.pop_entry(key)?;
        self.weight -= entry.weight;
        Some((key, entry))
    }
}

#[cfg(test)]
mod tests;

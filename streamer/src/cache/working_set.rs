//! How much views ask for: of several who share a cache the one who asks for most counts.

use std::sync::Arc;

use super::memory::Memory;

/// The place of one who asks a cache for what views want. Dropped, it asks for nothing.
#[derive(Debug)]
pub(crate) struct WorkingSet {
    memory: Arc<Memory>,
    bytes: u64,
}

impl WorkingSet {
    pub(super) fn new(memory: Arc<Memory>) -> Self {
        memory.replace_working_set(None, Some(0));
        Self { memory, bytes: 0 }
    }

    /// Takes note of how many bytes the present view asks the cache for, be they found or not: as
    /// much stays for what is new, whatever was used twice. That is less than the view shows
    /// where its receiver holds most of that already.
    pub(crate) fn set(&mut self, bytes: u64) {
        let before = std::mem::replace(&mut self.bytes, bytes);
        self.memory.replace_working_set(Some(before), Some(bytes));
    }
}

impl Drop for WorkingSet {
    fn drop(&mut self) {
        self.memory.replace_working_set(Some(self.bytes), None);
    }
}

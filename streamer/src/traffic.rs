//! What has passed over the wire.

use std::sync::atomic::{AtomicU64, Ordering};

/// Counts of one client, shared by all its calls.
#[derive(Debug, Default)]
pub(crate) struct Traffic {
    bytes: AtomicU64,
    requests: AtomicU64,
    abandoned: AtomicU64,
}

impl Traffic {
    pub(crate) fn request(&self) {
        self.requests.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn received(&self, bytes: usize) {
        self.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// Bytes of something that was given up before it was whole.
    pub(crate) fn abandoned(&self, bytes: u64) {
        self.abandoned.fetch_add(bytes, Ordering::Relaxed);
    }

    /// All of those.
    pub(crate) fn abandoned_bytes(&self) -> u64 {
        self.abandoned.load(Ordering::Relaxed)
    }

    /// Bytes of the messages received so far, without transport framing: the same over a
    /// network and in process.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    pub(crate) fn requests(&self) -> u64 {
        self.requests.load(Ordering::Relaxed)
    }
}

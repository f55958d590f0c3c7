//! What has passed, for people and reports.

use std::sync::atomic::{AtomicU64, Ordering};

/// What a streamer has done since it connected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Bytes of messages received, without transport framing: the same over a network and in
    /// process.
    pub bytes_received: u64,
    /// Of those, bytes of what was given up before it was whole, was damaged, or was not wanted any
    /// more when it came and has not been used since.
    pub bytes_wasted: u64,
    /// Requests sent.
    pub requests: u64,
    /// Requests that a new view made useless, ended on the wire.
    pub cancelled: u64,
    /// Parts that were asked for again because a server failed.
    pub retries: u64,
    /// Parts that were asked for again because they were damaged.
    pub refetched: u64,
    /// How often another server took over.
    pub failovers: u64,
    /// Parts found in memory or on disk.
    pub cache_hits: u64,
    /// Parts that were not.
    pub cache_misses: u64,
}

/// The counts that a session keeps itself.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub(super) cancelled: AtomicU64,
    pub(super) retries: AtomicU64,
    pub(super) refetched: AtomicU64,
    /// Bytes of what came and is not used.
    pub(super) unused: AtomicU64,
}

impl Counts {
    /// All that is counted here.
    pub(crate) fn read(&self) -> Statistics {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Statistics {
            bytes_wasted: of(&self.unused),
            cancelled: of(&self.cancelled),
            retries: of(&self.retries),
            refetched: of(&self.refetched),
            ..Statistics::default()
        }
    }
}

/// Adds to a count.
pub(super) fn add(count: &AtomicU64, by: u64) {
    count.fetch_add(by, Ordering::Relaxed);
}

/// Takes away from one.
pub(super) fn sub(count: &AtomicU64, by: u64) {
    count.fetch_sub(by, Ordering::Relaxed);
}

//! Memory that parallel work shares.

use std::path::Path;
use std::sync::{Condvar, Mutex, PoisonError};

use crate::ingest::{BadInput, IngestError};

/// Bytes that may be taken at the same time. Who takes more than is free waits; nobody
/// holds one share while waiting for another, so someone always goes on.
pub(super) struct Budget {
    total: u64,
    free: Mutex<u64>,
    released: Condvar,
}

/// A part of a [`Budget`], given back when dropped.
pub(super) struct Share<'a> {
    budget: &'a Budget,
    bytes: u64,
}

impl Budget {
    pub(super) fn new(total: u64) -> Self {
        Self { total, free: Mutex::new(total), released: Condvar::new() }
    }

    /// Waits until `bytes` are free and takes them; `None` if the budget is smaller than that.
    pub(super) fn take(&self, bytes: u64) -> Option<Share<'_>> {
        if bytes > self.total {
            return None;
        }
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        while *free < bytes {
            free = self.released.wait(free).unwrap_or_else(PoisonError::into_inner);
        }
        *free -= bytes;
        Some(Share { budget: self, bytes })
    }

    /// All of it.
    pub(super) fn total(&self) -> u64 {
        self.total
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        *self.budget.free.lock().unwrap_or_else(PoisonError::into_inner) += self.bytes;
        self.budget.released.notify_all();
    }
}

/// An image that cannot be decoded within the memory of the job.
pub(super) fn over_budget(path: &Path, needed: u64, budget: &Budget) -> IngestError {
    BadInput::error(
        path,
        "",
        format!(
            "it takes {} MiB to decode and halve, more than the budget of {} MiB",
            needed.div_ceil(1 << 20),
            budget.total() >> 20
        ),
        format!("ingest with --memory {}MiB or more", needed.div_ceil(1 << 20)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn takers_never_exceed_the_budget() {
        let budget = Budget::new(100);
        let (now, most) = (AtomicU64::new(0), AtomicU64::new(0));
        std::thread::scope(|scope| {
            for i in 0..8_u64 {
                let (budget, now, most) = (&budget, &now, &most);
                scope.spawn(move || {
                    for j in 0..200 {
                        let bytes = 20 + (i * 7 + j) % 60;
                        let _share = budget.take(bytes).expect("within the budget");
                        most.fetch_max(
                            now.fetch_add(bytes, Ordering::SeqCst) + bytes,
                            Ordering::SeqCst,
                        );
                        std::thread::yield_now();
                        now.fetch_sub(bytes, Ordering::SeqCst);
                    }
                });
            }
        });
        let most = most.into_inner();
        assert!(most <= 100 && most > 50, "{most}");
        assert!(budget.take(101).is_none());
        assert!(budget.take(100).is_some());
    }
}

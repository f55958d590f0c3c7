//! Payloads in a folder, which outlives the process.
//!
//! A file for each payload, in a folder of the cache's own: its name is the hash of the key, so
//! that no key can name a place elsewhere, and the key itself stands in the file and is compared.
//! A file appears under its name only when it is whole. It is not forced to the disk: after a
//! loss of power it may be short or empty, which its checksums tell.
//!
//! Readers need no lock: a file is whole, or damaged, or not there. Writers of all processes take
//! turns, so that what the folder takes together stays within its limit at every moment.

mod entry;
mod folder;
mod ledger;
mod writer;

#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use bytes::Bytes;
use tokio::sync::Semaphore;

use super::statistics::Counts;
use super::{CacheError, CacheKey, Checked, DiskOptions, Rank};
use entry::EntryError;
use folder::Folder;
use writer::Writer;

/// Files that are read at once; further ones wait their turn.
const READS: usize = 8;

/// Payloads in a folder.
#[derive(Debug)]
pub(super) struct Disk {
    /// The cache's own folder.
    path: PathBuf,
    limit: u64,
    reads: Arc<Semaphore>,
    /// Absent where the folder can only be read.
    writer: Option<Writer>,
    counts: Arc<Counts>,
}

impl Disk {
    /// Opens or makes the folder; `None`, with a warning, where neither can be done.
    pub(super) fn open(
        options: &DiskOptions,
        counts: Arc<Counts>,
    ) -> Result<Option<Self>, CacheError> {
        if options.folder.is_file() {
            return Err(CacheError::NotAFolder { folder: options.folder.clone() });
        }
        let path = match Folder::make(&options.folder) {
            Ok(path) => path,
            Err(error) => {
                tracing::warn!(%error, folder = %options.folder.display(),
                    "the cache's folder cannot be made: payloads are kept in memory alone");
                return Ok(None);
            }
        };
        let writer = Folder::open(path.clone(), options.bytes)
            .and_then(|folder| Writer::start(folder, Arc::clone(&counts)))
            .inspect_err(|error| {
                tracing::warn!(%error, folder = %path.display(),
                    "the cache cannot be written: new payloads are kept in memory alone");
            });
        let reads = Arc::new(Semaphore::new(READS));
        Ok(Some(Self { path, limit: options.bytes, reads, writer: writer.ok(), counts }))
    }

    /// The payload of `key`, where its file is sound and what is expected.
    pub(super) async fn get(
        &self,
        key: &CacheKey,
        expected: Option<Checked>,
    ) -> Option<(Bytes, Rank)> {
        let permit = Arc::clone(&self.reads).acquire_owned().await.ok()?;
        let (path, limit) = (self.path.join(entry::file_name(key)), self.limit);
        let (key, counts) = (key.clone(), Arc::clone(&self.counts));
        let read = tokio::task::spawn_blocking(move || {
            let _permit = permit;
            let error = match entry::read(&path, &key, limit, expected) {
                Ok(found) => return Some(found),
                // Not there, or not to be had now: nothing that removing it would mend.
                Err(EntryError::Io(_)) => return None,
                Err(error) => error,
            };
            counts.damaged.fetch_add(1, Relaxed);
            tracing::debug!(%error, ?key, "an entry of the cache is removed");
            // It may be gone already, or not be ours to remove: it is not used either way.
            drop(std::fs::remove_file(&path));
            None
        });
        read.await.ok().flatten()
    }

    /// Has `payload` written, unless too much waits for that.
    pub(super) fn insert(&self, key: &CacheKey, payload: Bytes, rank: Rank) {
        if let Some(writer) = &self.writer {
            writer.write(key.clone(), payload, rank);
        }
    }

    /// Has the entry of `key` removed, after what waits to be written.
    pub(super) fn remove(&self, key: &CacheKey) {
        if let Some(writer) = &self.writer {
            writer.remove(key.clone());
        }
    }

    /// Returns once everything that was inserted before has been dealt with.
    pub(super) async fn flush(&self) {
        if let Some(writer) = &self.writer {
            writer.flush().await;
        }
    }
}

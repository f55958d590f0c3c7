//! What every layer's ingest is given: limits, a place to work, and someone to tell.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::{IngestError, Warnings};

/// The circumstances of one layer's ingest. Layers run on blocking threads and may use rayon.
pub struct Job {
    /// Folder of this layer for intermediate and finished files, outside the store.
    pub work: PathBuf,
    /// Bytes of memory that the layer may take.
    pub memory: u64,
    /// Skip damaged files with a warning instead of stopping.
    pub skip_damaged: bool,
    progress: Arc<dyn Progress>,
    cancelled: Arc<AtomicBool>,
    warnings: Mutex<Warnings>,
}

/// What a stage counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Points.
    Points,
    /// Images.
    Images,
    /// Bytes.
    Bytes,
    /// Footprints, files and other things.
    Items,
}

/// Someone who shows progress: bars, plain lines, or nothing.
pub trait Progress: Send + Sync {
    /// Begins a stage of `total` units (0 where unknown). It ends when dropped.
    fn stage(&self, name: &str, total: u64, unit: Unit) -> Box<dyn Stage>;
}

/// A running stage.
pub trait Stage: Send + Sync {
    /// `n` more units are done.
    fn advance(&self, n: u64);
}

/// Shows nothing.
pub struct NoProgress;

impl Progress for NoProgress {
    fn stage(&self, _name: &str, _total: u64, _unit: Unit) -> Box<dyn Stage> {
        Box::new(NoProgress)
    }
}

impl Stage for NoProgress {
    fn advance(&self, _n: u64) {}
}

impl Job {
    /// A job that works in `work` (an existing folder), may take `memory` bytes, stops at
    /// damaged files and shows nothing.
    pub fn new(work: impl Into<PathBuf>, memory: u64) -> Self {
        Self {
            work: work.into(),
            memory,
            skip_damaged: false,
            progress: Arc::new(NoProgress),
            cancelled: Arc::default(),
            warnings: Mutex::default(),
        }
    }

    /// Shows its progress to `progress`.
    #[must_use]
    pub fn showing(mut self, progress: Arc<dyn Progress>) -> Self {
        self.progress = progress;
        self
    }

    /// The job of one layer: the same limits, in a folder of its own, with no warnings yet.
    /// Cancelling either cancels both.
    #[must_use]
    pub fn layer(&self, work: PathBuf) -> Self {
        Self {
            work,
            memory: self.memory,
            skip_damaged: self.skip_damaged,
            progress: Arc::clone(&self.progress),
            cancelled: Arc::clone(&self.cancelled),
            warnings: Mutex::default(),
        }
    }

    /// Begins a stage of `total` units (0 where unknown). It ends when dropped.
    pub fn stage(&self, name: &str, total: u64, unit: Unit) -> Box<dyn Stage> {
        self.progress.stage(name, total, unit)
    }

    /// Asks every layer to stop soon.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// An error once [`Job::cancel`] was called: to be asked at least every 0.2 s of work.
    pub fn check(&self) -> Result<(), IngestError> {
        if self.cancelled.load(Ordering::Relaxed) { Err(IngestError::Cancelled) } else { Ok(()) }
    }

    /// Notes something that was not used: its kind (`absent-image`, `degenerate-polygon`,
    /// `damaged-file`, …) and one line that names file, place and value.
    pub fn warn(&self, kind: &'static str, message: impl Into<String>) {
        let message = message.into();
        tracing::debug!(kind, message, "ingest warning");
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).add(kind, message);
    }

    /// What was noted so far.
    pub fn warnings(&self) -> Warnings {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

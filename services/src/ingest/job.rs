//! What every layer's ingest is given: limits, a place to work, and someone to tell.

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use super::IngestError;

/// The circumstances of one ingest. Layers run on blocking threads and may use rayon.
pub struct Job {
    /// Folder for intermediate and finished files, outside the store. Survives a kill.
    pub work: PathBuf,
    /// Bytes of memory that all of the ingest may take together.
    pub memory: u64,
    /// Skip damaged files with a warning instead of stopping.
    pub skip_damaged: bool,
    /// Refuse paths that leave the survey's folder.
    pub confine: bool,
    /// Where progress is shown.
    pub progress: Box<dyn Progress>,
    /// Set by [`Job::cancel`].
    pub cancelled: AtomicBool,
    /// What was noticed, in order.
    pub warnings: Mutex<Vec<Warning>>,
}

/// Something that ingest could not use, and went on without.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// The kind, for counting: `absent-image`, `degenerate-polygon`, `damaged-file`, ….
    pub kind: &'static str,
    /// One line that names file, place and value.
    pub message: String,
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
    /// Asks every layer to stop soon.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// An error once [`Job::cancel`] was called: to be asked at least every 0.2 s of work.
    pub fn check(&self) -> Result<(), IngestError> {
        if self.cancelled.load(Ordering::Relaxed) { Err(IngestError::Cancelled) } else { Ok(()) }
    }

    /// Notes something that was not used.
    pub fn warn(&self, kind: &'static str, message: impl Into<String>) {
        let message = message.into();
        tracing::debug!(kind, message, "ingest warning");
        self.warnings
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
            .push(Warning { kind, message });
    }
}

//! Whole ingests: files in, COPC out, both read back by the `las` crate and compared.

mod distributions;
mod hostile;
mod made;
mod merging;
mod round_trip;

use std::path::{Path, PathBuf};

use super::{PointsInput, StagedPoints, ingest_points};
use crate::ingest::{IngestError, Job};

/// A job in a folder that goes away with the value.
struct Workplace {
    job: Job,
    folder: tempfile::TempDir,
}

impl Workplace {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let job = Job::new(folder.path().join("work"), 2 << 30);
        Self { job, folder }
    }

    fn ingest(&self, files: &[&Path]) -> Result<Vec<StagedPoints>, IngestError> {
        let files = files.iter().map(|path| path.to_path_buf()).collect();
        ingest_points(&self.job, &[PointsInput { name: "survey".into(), files }])
    }

    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn warning_kinds(&self) -> Vec<String> {
        self.job.warnings().counts().into_keys().collect()
    }
}

/// The fault that an ingest of `files` stops at, as a person sees it.
fn fault(result: Result<Vec<StagedPoints>, IngestError>) -> String {
    match result {
        Err(IngestError::BadInput(fault)) => fault.to_string(),
        other => panic!("expected a fault of the input, got {other:?}"),
    }
}

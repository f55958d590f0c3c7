//! What can go wrong with an ingest.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why an ingest stopped. The store is as it was.
#[derive(Debug, thiserror::Error)]
pub enum IngestError {
    /// The survey's files are at fault.
    #[error(transparent)]
    BadInput(#[from] Box<BadInput>),
    /// A local file could not be read or written: the work folder, or a full disk.
    #[error("cannot {action} {path:?}: {source}; {remedy}", path = path.display())]
    Io {
        /// What was tried, as in "write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
        /// What to do.
        remedy: String,
    },
    /// The store refused.
    #[error("cannot {action} {object:?} in the store: {source}; {remedy}")]
    Store {
        /// What was tried, as in "write".
        action: &'static str,
        /// The object's path, or the store's URL.
        object: String,
        /// What the store said.
        source: object_store::Error,
        /// What to do.
        remedy: String,
    },
    /// Ctrl-C, or the caller gave up. What is complete in the work folder will be reused.
    #[error("interrupted; run the same command again to continue")]
    Cancelled,
}

/// One fault of an input: the file, the place in it, what is wrong there, what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadInput {
    /// The file at fault.
    pub file: PathBuf,
    /// Where in it: "line 12", "point 1234", "panorama 490, heading". May be empty.
    pub place: String,
    /// What is wrong, with the value.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

impl BadInput {
    /// The fault as an error.
    pub fn error(
        file: &Path,
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> IngestError {
        IngestError::BadInput(Box::new(Self {
            file: file.to_owned(),
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }))
    }
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if !self.place.is_empty() {
            write!(f, ", {}", self.place)?;
        }
        write!(f, ": {}; {}", self.problem, self.remedy)
    }
}

impl std::error::Error for BadInput {}

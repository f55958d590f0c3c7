//! What can go wrong with an ingest.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::store::StoreError;

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
    #[error("cannot {action} {object}: {source}")]
    Store {
        /// What was tried, as in "write".
        action: &'static str,
        /// The store's URL and the object's path in it.
        object: String,
        /// What the store said, and what to do.
        source: Box<StoreError>,
    },
    /// Another process works on the same scene of the same store.
    #[error(
        "another ingest of scene {scene:?} into this store is under way; wait for it to end \
         (it holds {folder:?})",
        folder = folder.display()
    )]
    Busy {
        /// The scene.
        scene: String,
        /// The work folder that it holds.
        folder: PathBuf,
    },
    /// Ctrl-C, or the caller gave up. What is complete in the work folder will be reused.
    #[error("interrupted; run the same command again to continue")]
    Cancelled,
}

impl IngestError {
    /// A local file that could not be read or written, with the remedy that the system's
    /// error suggests.
    pub fn io(action: &'static str, path: &Path, source: std::io::Error) -> Self {
        use std::io::ErrorKind;
        let remedy = match source.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
                "free some space there, or choose another work folder with --work"
            }
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                "choose a folder that this user may write to, with --work"
            }
            ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
                "a file is in the way of a folder: choose another work folder with --work"
            }
            _ => "check the disk of the work folder, or choose another with --work",
        };
        Self::Io { action, path: path.to_owned(), source, remedy: remedy.to_owned() }
    }

    /// A refusal of the store.
    pub fn store(action: &'static str, object: impl Into<String>, source: StoreError) -> Self {
        Self::Store { action, object: object.into(), source: Box::new(source) }
    }
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

    /// A fault of a JSON file, at the line and column where its parser stopped.
    pub fn json(file: &Path, fault: &serde_json::Error, remedy: impl Into<String>) -> IngestError {
        let position = format!(" at line {} column {}", fault.line(), fault.column());
        let text = fault.to_string();
        let place = format!("line {}, column {}", fault.line(), fault.column());
        // Faults of reading have no position.
        let place = if fault.line() == 0 { String::new() } else { place };
        Self::error(file, place, text.strip_suffix(&position).unwrap_or(&text), remedy)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_of_a_json_fault_is_said_once() {
        let fault = serde_json::from_str::<Vec<f64>>("[1,\n NaN]").expect_err("no JSON");
        let error = BadInput::json(Path::new("list.json"), &fault, "give numbers");
        assert_eq!(error.to_string(), "list.json, line 2, column 2: expected value; give numbers");
    }
}

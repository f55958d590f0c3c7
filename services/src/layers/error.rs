//! Why a stored layer cannot be read.

use object_store::path::Path;

/// What every reader of a layer can fail with.
#[derive(Debug, thiserror::Error)]
pub enum LayerError {
    /// The store did not give the bytes.
    #[error(transparent)]
    Store(#[from] object_store::Error),
    /// The object breaks its format.
    #[error("{path:?} is damaged, {place}: {problem}; ingest the scene again")]
    Damaged {
        /// The object.
        path: String,
        /// Where in it.
        place: String,
        /// What is wrong, with the value.
        problem: String,
    },
}

impl LayerError {
    /// The fault `problem` of the object `path` at `place`.
    pub(crate) fn damaged(path: &Path, place: impl Into<String>, problem: String) -> Self {
        Self::Damaged { path: path.to_string(), place: place.into(), problem }
    }

    /// The fault `problem` of the object `path` at its byte `offset`.
    pub(crate) fn at_byte(path: &Path, offset: u64, problem: String) -> Self {
        Self::damaged(path, format!("byte {offset}"), problem)
    }
}

//! What can go wrong with a store, and what to do about it.

use std::error::Error;
use std::io::ErrorKind;

/// Why a store, a scene or an object could not be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The URL names no store.
    #[error("{problem}; a store is a folder, or a URL such as s3://bucket/prefix: {url:?}")]
    BadUrl {
        /// What is wrong.
        problem: String,
        /// The URL as given.
        url: String,
    },
    /// A folder that should hold scenes does not exist.
    #[error(
        "no such folder; make a scene first with `flaneur ingest STREET --out STORE`: {folder:?}"
    )]
    NoFolder {
        /// The folder as given.
        folder: String,
    },
    /// The name cannot be a scene's.
    #[error("{name:?} cannot name a scene: {problem}")]
    BadSceneName {
        /// The name.
        name: String,
        /// Why not.
        problem: String,
    },
    /// No scene has the name.
    #[error("no scene is named {name:?}")]
    NoScene {
        /// The name.
        name: String,
    },
    /// Two stores hold a scene of the same name.
    #[error(
        "scene {name:?} is in two stores; serve them apart or rename one of its folders: {first} and {second}"
    )]
    SceneTwice {
        /// The scene.
        name: String,
        /// One store.
        first: String,
        /// The other.
        second: String,
    },
    /// A path does not stay below its scene.
    #[error("{path:?} is no path below a scene: {problem}")]
    BadPath {
        /// The path.
        path: String,
        /// Why not.
        problem: String,
    },
    /// The manifest is not one that this program reads.
    #[error("scene {scene:?} has a manifest that cannot be read: {problem}; ingest it again")]
    BadManifest {
        /// The scene.
        scene: String,
        /// What is wrong.
        problem: String,
    },
    /// An object of the scene is not as its manifest or format says.
    #[error("{object:?} is damaged: {problem}; ingest the scene again")]
    Damaged {
        /// Path of the object below its store.
        object: String,
        /// What is wrong, and where.
        problem: String,
    },
    /// A local file could not be read for publication.
    #[error("cannot read {path:?}: {source}")]
    LocalFile {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The store failed.
    #[error("the store failed: {source}; {}", remedy(.source))]
    Object {
        /// What it said.
        #[from]
        source: object_store::Error,
    },
}

/// For a store that knows the caller and refuses, or does not believe the signature.
const FORBIDDEN: &str = "check the credentials, and that they may read and write the store";

/// What a person can do about a failure of the store.
pub fn remedy(error: &object_store::Error) -> &'static str {
    match error {
        object_store::Error::PermissionDenied { .. } => return FORBIDDEN,
        object_store::Error::Unauthenticated { .. } => {
            return "set the store's credentials in the environment, as in AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY";
        }
        object_store::Error::NotFound { .. } => return "check the store's URL",
        _ => {}
    }
    match io_kind(error) {
        Some(ErrorKind::StorageFull | ErrorKind::QuotaExceeded) => {
            "free some space there, or choose another store"
        }
        Some(ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem) => {
            "make the folder writable for this user, or choose another store"
        }
        Some(ErrorKind::NotADirectory) => "a file is in the way of a folder; choose another store",
        // Lists are refused with an error of no kind; only its text tells.
        _ if error.to_string().contains("403 Forbidden") => FORBIDDEN,
        _ => "check that the store can be reached, then try again",
    }
}

/// The kind of the input or output error at the bottom of a store's error.
fn io_kind(error: &object_store::Error) -> Option<ErrorKind> {
    let mut cause: Option<&(dyn Error + 'static)> = Some(error);
    while let Some(error) = cause {
        if let Some(io) = error.downcast_ref::<std::io::Error>() {
            return Some(io.kind());
        }
        cause = error.source();
    }
    None
}

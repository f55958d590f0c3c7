//! What can go wrong.

use std::path::PathBuf;

/// Why a sample could not be written. Nothing is left behind.
#[derive(Debug, thiserror::Error)]
pub enum SampleError {
    /// A size is out of range.
    #[error("{name} is {value}: choose {range}")]
    Option {
        /// Which one.
        name: &'static str,
        /// What it was.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// The target holds something already.
    #[error("the folder is not empty: name a new one, or remove it first: {}", path.display())]
    NotEmpty {
        /// The target.
        path: PathBuf,
    },
    /// A file or folder could not be written.
    #[error("cannot write: {source}: {}", path.display())]
    Write {
        /// What the system said.
        source: std::io::Error,
        /// Which one.
        path: PathBuf,
    },
    /// An image could not be encoded or written.
    #[error("cannot write the image: {source}: {}", path.display())]
    Image {
        /// What the encoder said.
        source: image::ImageError,
        /// Which one.
        path: PathBuf,
    },
    /// Points could not be encoded or written.
    #[error("cannot write the points: {source}: {}", path.display())]
    Points {
        /// What the encoder said.
        source: las::Error,
        /// Which file.
        path: PathBuf,
    },
    /// Someone asked to stop.
    #[error("stopped before the sample was complete")]
    Cancelled,
}

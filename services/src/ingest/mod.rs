//! From a survey's files to a scene.
//!
//! Each layer has a folder of its own that reads the survey's formats and writes the layer's
//! stored form into the job's work folder; what is complete there survives a kill. Publication
//! then copies the files into the store and writes the manifest last.

mod error;
pub mod ground;
mod job;
pub mod panoramas;
pub mod points;
pub mod street;
mod warnings;

pub use error::{BadInput, IngestError};
pub use job::{Job, NoProgress, Progress, Stage, Unit};
pub use warnings::Warnings;

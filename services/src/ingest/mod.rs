//! From a survey's files to a scene.
//!
//! Each layer has a folder of its own that reads the survey's formats and writes the layer's
//! stored form into the job's work folder; what is complete there survives a kill. Publication
//! then copies the files into the store and writes the manifest last.

mod assemble;
mod build;
mod error;
mod fingerprint;
mod follow;
pub mod footprints;
pub mod ground;
mod inputs;
mod job;
mod leftovers;
pub mod panoramas;
mod plan;
pub mod points;
mod publish;
mod run;
pub mod street;
mod summary;
mod warnings;
mod workspace;

pub use error::{BadInput, IngestError};
pub use job::{Job, NoProgress, Progress, Stage, Unit};
pub use run::{IngestOptions, ingest};
pub use summary::Summary;
pub use warnings::Warnings;

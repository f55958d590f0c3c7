#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod cadastre;
mod camera;
mod description;
mod error;
mod files;
mod frame;
mod geometry;
mod lidar;
mod look;
mod options;
mod progress;
mod street;
mod write;

pub use error::SampleError;
pub use files::read_depths;
pub use lidar::RANGE_SIGMA_M;
pub use options::SampleOptions;
pub use progress::{Progress, Stage, Summary};
pub use street::Class;
pub use write::write_street;

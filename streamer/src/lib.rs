#![doc = include_str!("../README.md")]

mod cache;
mod choose;
mod client;
mod decode;
mod error;
mod event;
mod limits;
mod load;
mod plan;
mod request;
mod servers;
mod session;
mod sight;
mod streamer;
mod survey;
mod traffic;

pub use cache::{CacheError, CacheOptions, CacheStatistics, DiskOptions, Rank, SegmentedLru};
pub use choose::{ChosenNodes, Hierarchy, WantedNode, choose_nodes};
pub use client::{Client, HierarchyEntry};
pub use decode::{Picture, SurveyedPoint};
pub use error::StreamError;
pub use event::{Event, Progress};
pub use limits::FetchLimits;
pub use plan::Order;
pub use request::{Gaze, ViewRequest};
pub use servers::Servers;
pub use session::Statistics;
pub use streamer::{Events, StreamOptions, Streamer};

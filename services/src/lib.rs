//! Ingest, the store, and the gRPC data services.
//!
//! - [`ingest`] turns a survey's files into a scene,
//! - [`layers`] are the formats in which a scene's parts are stored: each file writes and
//!   reads one of them,
//! - [`crs`] knows where grid north lies,
//! - [`store`] finds scenes and their objects behind a URL,
//! - [`place`] is what a survey has stored of a place that a picture shows,
//! - [`shares`] says how much of a picture shows nothing of a survey,
//! - [`gps_time`] knows when in UTC it was measured,
//! - [`grpc`] answers the data services over a store,
//! - [`render`] answers the render service, a client of the data services.

mod cache;
pub mod crs;
mod geography;
pub mod gps_time;
pub mod grpc;
pub mod ingest;
pub mod layers;
mod page;
pub mod picture;
pub mod place;
pub mod render;
pub mod shares;
pub mod store;

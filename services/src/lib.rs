//! Ingest, the store, and the gRPC data services.
//!
//! - [`ingest`] turns a survey's files into a scene,
//! - [`layers`] are the formats in which a scene's parts are stored: each file writes and
//!   reads one of them,
//! - [`crs`] knows where grid north lies,
//! - [`store`] finds scenes and their objects behind a URL,
//! - [`grpc`] answers the data services over a store,
//! - [`render`] answers the render service, a client of the data services.

mod cache;
pub mod crs;
mod geography;
mod gps_time;
pub mod grpc;
pub mod ingest;
pub mod layers;
mod page;
pub mod picture;
pub mod render;
pub mod store;

//! The stored formats of a scene's layers, each a standard one that can be read without
//! Flaneur: FlatGeobuf for footprints and panoramas, GeoTIFF for the ground, COPC for points,
//! JPEG pyramids for photographs, JSON for where points were taken from and for poses as they were delivered.
//!
//! A layer's file holds both its writer, used by [`crate::ingest`], and its reader, used by
//! [`crate::grpc`], so that the two cannot drift apart.

mod attributes;
pub mod copc;
pub mod delivered;
mod error;
pub mod fgb;
pub mod footprints;
pub mod ground;
pub mod panoramas;
pub mod stations;

pub use attributes::AttributeColumns;
pub use error::LayerError;

//! The `flaneur.v1` wire contract: messages, clients, servers, and the checked
//! conversions between messages and the types of [`flaneur_scene`].
//!
//! A scene type becomes a message with `From`; a message becomes a scene type with `TryFrom`,
//! whose [`FieldError`] names the field at fault. Messages come from outside: whatever a
//! conversion lets through is finite, in range and consistent.
//!
//! Knows the scene types and nothing of stores, renderers or streaming policy.

mod error;
mod footprint;
mod geometry;
mod ground;
mod panorama;
mod parts;
mod point;
mod region;
mod render;
mod scene;
mod stations;

pub use error::FieldError;
pub use ground::MAX_GROUND_STEP;
pub use parts::{Assembly, PART_BYTES, split};

/// The generated messages, clients and servers; documented in `proto/flaneur/v1/*.proto`.
#[allow(
    missing_docs,
    unreachable_pub,
    clippy::all,
    clippy::pedantic,
    clippy::allow_attributes_without_reason,
    reason = "generated code"
)]
pub mod v1 {
    tonic::include_proto!("flaneur.v1");
}

/// The encoded `FileDescriptorSet` of the contract, for server reflection.
pub const FILE_DESCRIPTOR_SET: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/flaneur.v1.bin"));

/// Most keys that one request may name, as the .proto files state.
pub const MAX_KEYS: usize = 4096;

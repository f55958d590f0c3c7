//! The `flaneur.v1` wire contract: messages, clients, servers, and the checked
//! conversions between messages and the types of [`flaneur_scene`].
//!
//! Knows the scene types and nothing of stores, renderers or streaming policy.

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

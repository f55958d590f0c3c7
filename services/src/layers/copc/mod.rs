//! COPC: one LAZ file per point source, ordered as an octree, with an index of its nodes.
//! <https://copc.io>, version 1.0, over LAS 1.4.

mod checksums;
mod hierarchy;
mod read;
mod vlr;
mod write;

pub(crate) use checksums::is_checksums;
pub use read::{CopcFile, Page, PageAddress, PageEntry, PageItem};
pub use vlr::{Evlr, Vlr};
pub(crate) use write::base_record_length;
pub use write::{CopcHeader, CopcSummary, CopcWriter, NodeCompressor, compress_node};

#[cfg(test)]
pub(crate) use read::tests::{deep_tree, write_copc};

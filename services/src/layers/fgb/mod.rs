//! FlatGeobuf files read by ranges from an object store.
//!
//! The `flatgeobuf` crate writes our files; its own remote reader brings an HTTP client and
//! trusts what it reads. This one asks the store only for the header, the branches of the
//! packed R-tree that meet a region, and the features found there, and checks every size
//! and offset against the file before it takes memory.

mod attributes;
mod feature;
mod index;
mod polygons;

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use bytes::{Buf, Bytes, BytesMut};
use flaneur_scene::Region;
use flatgeobuf::{Header, size_prefixed_root_as_header};
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};

pub use attributes::attributes;
pub use feature::FgbFeature;
use index::IndexLayout;
pub use polygons::Polygons;

use crate::layers::LayerError;

/// A FlatGeobuf object of a store, its header read and checked.
#[derive(Clone, Debug)]
pub struct FgbFile {
    store: Arc<dyn ObjectStore>,
    path: Path,
    size: u64,
    /// The header with its size prefix; verified.
    header: Bytes,
    index: Option<IndexLayout>,
    features_start: u64,
}

/// The features of a selection, read piece by piece, in the file's order.
#[derive(Debug)]
pub struct FgbCursor {
    file: FgbFile,
    /// Byte ranges still to be read, each made of whole features.
    runs: VecDeque<Range<u64>>,
    /// What has been read of the first run and not been given out.
    buffer: BytesMut,
    /// Features to come, where the whole file is read and says how many it holds.
    left: Option<u64>,
}

/// Magic bytes, of which the fourth is the version and the last the patch level.
const MAGIC: [u8; 7] = *b"fgb\x03fgb";
/// Magic bytes and the header's size.
const PREAMBLE: u64 = 12;
/// A header holds a few hundred bytes a column.
const MAX_HEADER: u32 = 10 << 20;
/// The largest feature: a footprint of a few million vertices.
const MAX_FEATURE: u32 = 64 << 20;
/// Bytes asked for at once.
const PIECE: u64 = 1 << 20;
/// Features this close are read together, and what lies between is given out too.
const GAP: u64 = 64 << 10;

impl FgbFile {
    /// Opens `path`, of `size` bytes, reading nothing but the header.
    pub async fn open(
        store: Arc<dyn ObjectStore>,
        path: Path,
        size: u64,
    ) -> Result<Self, LayerError> {
        let damaged = |offset, problem: String| LayerError::at_byte(&path, offset, problem);
        if size < PREAMBLE {
            return Err(damaged(0, format!("{size} bytes are no FlatGeobuf")));
        }
        // The header nearly always fits into this first piece.
        let mut head = store.get_range(&path, 0..size.min(8 << 10)).await?;
        let Some((magic, rest)) = head.split_at_checked(8) else {
            return Err(damaged(0, format!("the store holds fewer than {size} bytes")));
        };
        if magic[..7] != MAGIC {
            return Err(damaged(0, format!("starts with {magic:?}, not with {MAGIC:?}")));
        }
        let length = rest.first_chunk().map_or(u32::MAX, |bytes| u32::from_le_bytes(*bytes));
        let features_or_index = PREAMBLE + u64::from(length);
        if length > MAX_HEADER || features_or_index > size {
            return Err(damaged(8, format!("a header of {length} bytes in {size}")));
        }
        if features_or_index > head.len() as u64 {
            head = store.get_range(&path, 0..features_or_index).await?;
        }
        if features_or_index > head.len() as u64 {
            return Err(damaged(8, format!("the store holds fewer than {size} bytes")));
        }
        let header = head.slice(8..features_or_index as usize);
        let parsed = size_prefixed_root_as_header(&header)
            .map_err(|e| damaged(8, format!("the header is no flatbuffer: {e}")))?;
        let (count, node_size) = (parsed.features_count(), parsed.index_node_size());
        let index = if node_size > 0 && count > 0 {
            let index = IndexLayout::new(features_or_index, count, node_size, size);
            Some(index.ok_or_else(|| {
                damaged(
                    features_or_index,
                    format!("an index of {count} features, {node_size} a node, in {size} bytes"),
                )
            })?)
        } else {
            None
        };
        let features_start = index.as_ref().map_or(features_or_index, IndexLayout::end);
        Ok(Self { store, path, size, header, index, features_start })
    }

    /// The header: columns, feature count, geometry type.
    pub fn header(&self) -> Header<'_> {
        size_prefixed_root_as_header(&self.header).expect("verified when it was opened")
    }

    /// All features whose box meets the region's rectangle, and possibly a few that lie
    /// between them in the file: the caller tests the geometry.
    pub async fn select(&self, region: &Region) -> Result<FgbCursor, LayerError> {
        let (runs, left) = match (region.bounds(), &self.index) {
            (Some(bounds), Some(index)) => (index.search(self, &bounds).await?, None),
            _ => (
                std::iter::once(self.features_start..self.size).collect(),
                Some(self.header().features_count()).filter(|&count| count > 0),
            ),
        };
        let runs = runs.into_iter().filter(|run| !run.is_empty()).collect();
        Ok(FgbCursor { file: self.clone(), runs, buffer: BytesMut::new(), left })
    }

    fn damaged(&self, offset: u64, problem: String) -> LayerError {
        LayerError::at_byte(&self.path, offset, problem)
    }
}

impl FgbCursor {
    /// The next feature, or `None` after the last.
    pub async fn next(&mut self) -> Result<Option<FgbFeature>, LayerError> {
        while self.runs.front().is_some_and(|run| run.is_empty()) && self.buffer.is_empty() {
            self.runs.pop_front();
        }
        if self.runs.is_empty() {
            return match self.left {
                Some(left @ 1..) => {
                    let problem = format!("the file ends {left} features early");
                    Err(self.file.damaged(self.file.size, problem))
                }
                _ => Ok(None),
            };
        }
        self.left = self.left.map(|left| left.saturating_sub(1));
        self.fill(4).await?;
        let offset = self.offset();
        let length = self.buffer.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        if length > MAX_FEATURE {
            let problem = format!("a feature of {length} bytes, more than {MAX_FEATURE}");
            return Err(self.file.damaged(offset, problem));
        }
        let whole = 4 + length as usize;
        self.fill(whole).await?;
        let bytes = self.buffer.split_to(whole).freeze();
        FgbFeature::parse(bytes).map(Some).map_err(|e| self.file.damaged(offset, e))
    }

    /// The header of the file that the features come from.
    pub fn header(&self) -> Header<'_> {
        self.file.header()
    }

    /// Name of the object, for messages.
    pub fn path(&self) -> &Path {
        &self.file.path
    }

    /// Position in the file of the first byte of the buffer.
    pub fn offset(&self) -> u64 {
        self.runs.front().map_or(self.file.size, |run| run.start) - self.buffer.len() as u64
    }

    /// Reads on until the buffer holds `length` bytes.
    async fn fill(&mut self, length: usize) -> Result<(), LayerError> {
        let offset = self.offset();
        while self.buffer.len() < length {
            let missing = (length - self.buffer.len()) as u64;
            let run = self.runs.front_mut().filter(|run| run.end - run.start >= missing);
            let Some(run) = run else {
                let problem = format!("a feature of {length} bytes runs past its range");
                return Err(self.file.damaged(offset, problem));
            };
            let piece = run.start..run.end.min(run.start + missing.max(PIECE));
            let bytes = self.file.store.get_range(&self.file.path, piece.clone()).await?;
            if bytes.remaining() as u64 != piece.end - piece.start {
                let problem = format!("the store gave {} bytes of {piece:?}", bytes.len());
                return Err(self.file.damaged(piece.start, problem));
            }
            run.start = piece.end;
            self.buffer.extend_from_slice(&bytes);
        }
        Ok(())
    }
}

//! Resident points, in pages that fit the device's storage bindings.
//!
//! A page holds blocks of [`BLOCK_POINTS`] records; a chunk takes as many blocks as it needs,
//! anywhere. A draw list names the blocks of the chunks that a camera may see.
//!
//! Octree nodes are additive: where finer nodes are resident, the points of the nodes above
//! them are drawn as finely as theirs, so that coarse discs do not hide fine ones. The
//! records are kept on the host too, 16 bytes a point, to be able to undo that.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use flaneur_scene::{Bounds3, NodeKey, PointChunk, PointNodeId};
use glam::DVec3;

use crate::frustum::Frustum;
use crate::{Gpu, RenderError, Settings};

mod pages;
mod record;

use pages::{BLOCK_BYTES, Pages, Part};
use record::{Record, radius_code, records, reset, shrink_within};

/// Points of a block: one workgroup of the splat pass.
pub(crate) const BLOCK_POINTS: usize = 256;

/// All resident chunks.
#[derive(Debug, Default)]
pub(crate) struct PointStore {
    pages: Pages,
    /// Ordered, so that ties of depth do not depend on the order of arrival.
    chunks: BTreeMap<PointNodeId, Chunk>,
    /// Chunks whose records differ from the device's.
    stale: BTreeSet<PointNodeId>,
    pub(crate) refused: u64,
}

#[derive(Debug)]
struct Chunk {
    origin: DVec3,
    bounds: Bounds3,
    radius_m: f32,
    records: Vec<Record>,
    parts: Vec<Part>,
}

/// Where points were lost and gained; boxes are empty where none were.
#[derive(Debug)]
pub(crate) struct Change {
    pub(crate) removed: Bounds3,
    pub(crate) added: Bounds3,
}

/// Blocks to be drawn for one camera, grouped by page.
#[derive(Debug, Default)]
pub(crate) struct DrawList {
    /// Block in its page, place in `placements`.
    pub(crate) blocks: Vec<[u32; 2]>,
    /// Chunk origins relative to the camera; then the radius of all points of the chunk in
    /// metres, 0 where each has its own.
    pub(crate) placements: Vec<[f32; 4]>,
    /// Page and its share of `blocks`.
    pub(crate) pages: Vec<(usize, Range<u32>)>,
    pub(crate) points: u64,
}

impl PointStore {
    /// Adds a chunk, or replaces the one with the same identity.
    pub(crate) fn insert(
        &mut self,
        gpu: &Gpu,
        settings: &Settings,
        chunk: &PointChunk,
    ) -> Result<Change, RenderError> {
        check(chunk)?;
        let radius_m = (chunk.spacing_m * settings.splat_scale).min(settings.max_splat_radius_m);
        let code = radius_code(radius_m);
        let (records, bounds) = records(chunk, code);
        let blocks = blocks(&records);
        let held: u64 = self.chunks.values().map(|chunk| blocks_u64(&chunk.records)).sum();
        let replaced = self.chunks.get(&chunk.id).map_or(0, |chunk| blocks_u64(&chunk.records));
        let needed = (held - replaced + u64::from(blocks)) * BLOCK_BYTES;
        if needed > settings.point_memory_bytes {
            let budget = settings.point_memory_bytes;
            return Err(RenderError::PointMemory { needed, budget });
        }
        let removed = self.remove(chunk.id);
        self.refused += (chunk.positions.len() - records.len()) as u64;
        if records.is_empty() {
            return Ok(Change { removed, added: Bounds3::EMPTY });
        }
        let parts = self.pages.take(gpu, blocks);
        let chunk_here = Chunk { origin: chunk.origin, bounds, radius_m, records, parts };
        self.chunks.insert(chunk.id, chunk_here);
        self.refine(chunk.id);
        for above in ancestors(chunk.id) {
            if let Some(coarse) = self.chunks.get_mut(&above)
                && shrink_within(&mut coarse.records, coarse.origin, &bounds, code)
            {
                self.stale.insert(above);
            }
        }
        Ok(Change { removed, added: bounds })
    }

    /// Removes a chunk; gives its box, empty where there was none.
    pub(crate) fn remove(&mut self, id: PointNodeId) -> Bounds3 {
        let Some(chunk) = self.chunks.remove(&id) else { return Bounds3::EMPTY };
        self.stale.remove(&id);
        for part in chunk.parts {
            self.pages.give_back(part);
        }
        for above in ancestors(id) {
            self.refine(above);
        }
        chunk.bounds
    }

    /// Brings the device up to date.
    pub(crate) fn upload(&mut self, gpu: &Gpu) {
        for id in std::mem::take(&mut self.stale) {
            if let Some(chunk) = self.chunks.get(&id) {
                self.pages.write(gpu, &chunk.parts, &chunk.records);
            }
        }
    }

    pub(crate) fn point_count(&self) -> u64 {
        self.chunks.values().map(|chunk| chunk.records.len() as u64).sum()
    }

    pub(crate) fn page(&self, page: usize) -> &wgpu::Buffer {
        self.pages.buffer(page)
    }

    /// What `frustum` may see, each point as large as what is resident around it allows.
    pub(crate) fn view_list(&self, frustum: &Frustum, centre: DVec3) -> DrawList {
        self.draw_list(frustum, centre, |_, _| Some(0.0))
    }

    /// What `frustum` may see of the chunks that `wanted` admits. Points have the size of
    /// their own chunk, at most `max_radius_m`, so that a map does not depend on the order
    /// in which chunks arrive.
    pub(crate) fn map_list(
        &self,
        frustum: &Frustum,
        centre: DVec3,
        max_radius_m: f32,
        wanted: impl Fn(&PointNodeId) -> bool,
    ) -> DrawList {
        self.draw_list(frustum, centre, |id, chunk| {
            wanted(id).then_some(chunk.radius_m.min(max_radius_m))
        })
    }

    fn draw_list(
        &self,
        frustum: &Frustum,
        centre: DVec3,
        radius: impl Fn(&PointNodeId, &Chunk) -> Option<f32>,
    ) -> DrawList {
        let mut list = DrawList::default();
        let mut by_page: Vec<Vec<[u32; 2]>> = vec![Vec::new(); self.pages.len()];
        for (id, chunk) in &self.chunks {
            let Some(radius_m) = radius(id, chunk) else { continue };
            if !frustum.meets_box(&chunk.bounds, f64::from(chunk.radius_m)) {
                continue;
            }
            let placement = list.placements.len() as u32;
            let [x, y, z] = (chunk.origin - centre).as_vec3().to_array();
            list.placements.push([x, y, z, radius_m]);
            list.points += chunk.records.len() as u64;
            for part in &chunk.parts {
                by_page[part.page].extend(part.blocks.clone().map(|block| [block, placement]));
            }
        }
        for (page, blocks) in by_page.into_iter().enumerate().filter(|(_, b)| !b.is_empty()) {
            let first = list.blocks.len() as u32;
            list.blocks.extend(blocks);
            list.pages.push((page, first..list.blocks.len() as u32));
        }
        list
    }

    /// Sets the radii of a chunk's points from its own and those of the nodes below it.
    fn refine(&mut self, id: PointNodeId) {
        let below: Vec<(Bounds3, u32)> = self
            .chunks
            .iter()
            .filter(|(other, _)| is_below(other, &id))
            .map(|(_, chunk)| (chunk.bounds, radius_code(chunk.radius_m)))
            .collect();
        let Some(chunk) = self.chunks.get_mut(&id) else { return };
        reset(&mut chunk.records, radius_code(chunk.radius_m));
        for (bounds, code) in below {
            shrink_within(&mut chunk.records, chunk.origin, &bounds, code);
        }
        self.stale.insert(id);
    }
}

/// The nodes above, nearest first.
fn ancestors(id: PointNodeId) -> impl Iterator<Item = PointNodeId> {
    std::iter::successors(id.key.parent(), NodeKey::parent)
        .map(move |key| PointNodeId { source: id.source, key })
}

fn is_below(other: &PointNodeId, id: &PointNodeId) -> bool {
    let (o, k) = (other.key, id.key);
    let levels = o.level.saturating_sub(k.level);
    let up = |cell: u32| cell.checked_shr(levels).unwrap_or(0);
    other.source == id.source && levels > 0 && (up(o.x), up(o.y), up(o.z)) == (k.x, k.y, k.z)
}

fn blocks(records: &[Record]) -> u32 {
    records.len().div_ceil(BLOCK_POINTS) as u32
}

fn blocks_u64(records: &[Record]) -> u64 {
    u64::from(blocks(records))
}

fn check(chunk: &PointChunk) -> Result<(), RenderError> {
    let (positions, colours) = (chunk.positions.len(), chunk.colours.len());
    if colours != 0 && colours != positions {
        return Err(RenderError::PointColumns { id: chunk.id, positions, colours });
    }
    if !(chunk.spacing_m > 0.0 && chunk.spacing_m.is_finite() && chunk.origin.is_finite()) {
        return Err(RenderError::PointSpacing { id: chunk.id, spacing_m: chunk.spacing_m });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_below_share_the_cell() {
        let id = |level, x| PointNodeId { source: 0, key: NodeKey { level, x, y: 0, z: 0 } };
        assert!(is_below(&id(3, 5), &id(1, 1)) && is_below(&id(1, 1), &id(0, 0)));
        assert!(!is_below(&id(3, 5), &id(1, 0)) && !is_below(&id(1, 1), &id(1, 1)));
        assert!(!is_below(&PointNodeId { source: 1, ..id(3, 5) }, &id(1, 1)));
        let above: Vec<_> = ancestors(id(2, 3)).collect();
        assert_eq!(above, [id(1, 1), id(0, 0)]);
    }
}

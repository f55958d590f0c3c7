//! Resident points, in pages that fit the device's storage bindings.
//!
//! A page holds blocks of [`BLOCK_POINTS`] records; a chunk takes as many blocks as it needs,
//! anywhere. A draw list names the blocks of the chunks that a camera may see.

use std::collections::BTreeMap;
use std::ops::Range;

use flaneur_scene::{Bounds3, PointChunk, PointNodeId};
use glam::{DVec3, Vec3};

use crate::frustum::Frustum;
use crate::{Gpu, RenderError, Settings};

/// Points of a block: one workgroup of the splat pass.
pub(crate) const BLOCK_POINTS: usize = 256;
/// Blocks of a page: 32 MiB.
const PAGE_BLOCKS: u32 = 8192;
const BLOCK_BYTES: u64 = (BLOCK_POINTS * 16) as u64;
/// Points further than this from their chunk's origin are refused: f32 is off by 6 cm there.
const MAX_OFFSET_M: f32 = 1e6;

/// Code of a record without a colour whose radius code is 0: no point.
const NO_POINT: [u32; 4] = [0; 4];
const HAS_COLOUR: u32 = 1 << 31;

/// All resident chunks.
#[derive(Debug, Default)]
pub(crate) struct PointStore {
    pages: Vec<Page>,
    /// Ordered, so that ties of depth do not depend on the order of arrival.
    chunks: BTreeMap<PointNodeId, Chunk>,
    pub(crate) refused: u64,
}

#[derive(Debug)]
struct Page {
    buffer: wgpu::Buffer,
    /// Ascending, disjoint, not touching.
    free: Vec<Range<u32>>,
}

#[derive(Debug)]
struct Chunk {
    origin: DVec3,
    bounds: Bounds3,
    radius_m: f32,
    points: u64,
    parts: Vec<(usize, Range<u32>)>,
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
    /// Chunk origins relative to the camera.
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
        let (records, bounds) = records(chunk, radius_code(radius_m));
        let points = records.len() as u64;
        let blocks = records.len().div_ceil(BLOCK_POINTS) as u32;
        let held: u64 = self.chunks.values().map(Chunk::blocks).sum();
        let replaced = self.chunks.get(&chunk.id).map_or(0, Chunk::blocks);
        let needed = (held - replaced + u64::from(blocks)) * BLOCK_BYTES;
        if needed > settings.point_memory_bytes {
            let budget = settings.point_memory_bytes;
            return Err(RenderError::PointMemory { needed, budget });
        }
        let removed = self.remove(chunk.id);
        self.refused += chunk.positions.len() as u64 - points;
        if blocks == 0 {
            return Ok(Change { removed, added: Bounds3::EMPTY });
        }
        let parts = self.allocate(gpu, blocks);
        self.upload(gpu, &parts, records);
        self.chunks
            .insert(chunk.id, Chunk { origin: chunk.origin, bounds, radius_m, points, parts });
        Ok(Change { removed, added: bounds })
    }

    /// Removes a chunk; gives its box, empty where there was none.
    pub(crate) fn remove(&mut self, id: PointNodeId) -> Bounds3 {
        let Some(chunk) = self.chunks.remove(&id) else { return Bounds3::EMPTY };
        for (page, blocks) in chunk.parts {
            release(&mut self.pages[page].free, blocks);
        }
        chunk.bounds
    }

    pub(crate) fn point_count(&self) -> u64 {
        self.chunks.values().map(|chunk| chunk.points).sum()
    }

    pub(crate) fn page(&self, page: usize) -> &wgpu::Buffer {
        &self.pages[page].buffer
    }

    /// The blocks of the chunks that `frustum` may see and that `wanted` admits.
    pub(crate) fn draw_list(
        &self,
        frustum: &Frustum,
        centre: DVec3,
        wanted: impl Fn(&PointNodeId) -> bool,
    ) -> DrawList {
        let mut list = DrawList::default();
        let mut by_page: Vec<Vec<[u32; 2]>> = vec![Vec::new(); self.pages.len()];
        for (id, chunk) in &self.chunks {
            if !wanted(id) || !frustum.meets_box(&chunk.bounds, f64::from(chunk.radius_m)) {
                continue;
            }
            let placement = list.placements.len() as u32;
            let [x, y, z] = (chunk.origin - centre).as_vec3().to_array();
            list.placements.push([x, y, z, 0.0]);
            list.points += chunk.points;
            for (page, blocks) in &chunk.parts {
                by_page[*page].extend(blocks.clone().map(|block| [block, placement]));
            }
        }
        for (page, blocks) in by_page.into_iter().enumerate().filter(|(_, b)| !b.is_empty()) {
            let first = list.blocks.len() as u32;
            list.blocks.extend(blocks);
            list.pages.push((page, first..list.blocks.len() as u32));
        }
        list
    }

    /// Takes blocks from the pages' free ranges, lowest first, and adds pages as needed.
    fn allocate(&mut self, gpu: &Gpu, mut blocks: u32) -> Vec<(usize, Range<u32>)> {
        let mut parts = Vec::new();
        let mut page = 0;
        while blocks > 0 {
            if page == self.pages.len() {
                self.pages.push(Page::new(gpu));
            }
            let free = &mut self.pages[page].free;
            while blocks > 0
                && let Some(range) = free.first_mut()
            {
                let taken = range.start..range.end.min(range.start + blocks);
                blocks -= taken.end - taken.start;
                range.start = taken.end;
                if range.start == range.end {
                    free.remove(0);
                }
                parts.push((page, taken));
            }
            page += 1;
        }
        parts
    }

    fn upload(&self, gpu: &Gpu, parts: &[(usize, Range<u32>)], mut records: Vec<[u32; 4]>) {
        records.resize(records.len().next_multiple_of(BLOCK_POINTS), NO_POINT);
        let mut rest = records.as_slice();
        for (page, blocks) in parts {
            let (part, after) = rest.split_at(blocks.len() * BLOCK_POINTS);
            let offset = u64::from(blocks.start) * BLOCK_BYTES;
            gpu.queue.write_buffer(&self.pages[*page].buffer, offset, bytemuck::cast_slice(part));
            rest = after;
        }
    }
}

impl Page {
    fn new(gpu: &Gpu) -> Self {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("points"),
            size: u64::from(PAGE_BLOCKS) * BLOCK_BYTES,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { buffer, free: std::iter::once(0..PAGE_BLOCKS).collect() }
    }
}

impl Chunk {
    fn blocks(&self) -> u64 {
        self.parts.iter().map(|(_, blocks)| blocks.len() as u64).sum()
    }
}

/// The code (1 to 127) of the radius nearest to `radius_m`: eight steps an octave from 1 mm,
/// so within 4.5 %.
fn radius_code(radius_m: f32) -> u32 {
    (8.0 * (radius_m / 0.001).log2()).round().clamp(1.0, 127.0) as u32
}

/// The records of the points that can be drawn, and their box in the world.
fn records(chunk: &PointChunk, radius_code: u32) -> (Vec<[u32; 4]>, Bounds3) {
    let mut bounds = Bounds3::EMPTY;
    let mut records = Vec::with_capacity(chunk.positions.len());
    for (i, &position) in chunk.positions.iter().enumerate() {
        // Written so that NaN is refused.
        if !position.iter().all(|x| x.abs() <= MAX_OFFSET_M) {
            continue;
        }
        bounds.include(chunk.origin + Vec3::from_array(position).as_dvec3());
        let colour = chunk
            .colours
            .get(i)
            .map_or(0, |&[r, g, b]| HAS_COLOUR | u32::from_le_bytes([r, g, b, 0]));
        let [x, y, z] = position.map(f32::to_bits);
        records.push([x, y, z, colour | radius_code << 24]);
    }
    (records, bounds)
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

/// Puts `blocks` back among the free ranges, joined with its neighbours.
fn release(free: &mut Vec<Range<u32>>, blocks: Range<u32>) {
    let at = free.partition_point(|range| range.end < blocks.start);
    let mut joined = blocks;
    while let Some(next) = free.get(at)
        && next.start <= joined.end
    {
        joined = joined.start.min(next.start)..joined.end.max(next.end);
        free.remove(at);
    }
    free.insert(at, joined);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn released_ranges_join() {
        let mut free = vec![0..2, 8..10];
        release(&mut free, 4..6);
        assert_eq!(free, [0..2, 4..6, 8..10]);
        release(&mut free, 2..4);
        assert_eq!(free, [0..6, 8..10]);
        release(&mut free, 6..8);
        assert_eq!(free, vec![0..10]);
    }

    #[test]
    fn radius_codes_are_within_half_a_step() {
        for radius_m in [0.0012f32, 0.035, 0.25, 3.0, 50.0] {
            let decoded = 0.001 * (radius_code(radius_m) as f32 * 0.125).exp2();
            assert!((decoded / radius_m).log2().abs() <= 0.0626, "{radius_m} {decoded}");
        }
    }
}

//! Resident points, in pages that fit the device's storage bindings.
//!
//! A page holds blocks of [`BLOCK_POINTS`] records; a chunk takes as many blocks as it needs,
//! anywhere. A draw list names the blocks that a camera may see.
//!
//! Octree nodes are additive: where finer nodes are resident, the points of the nodes above
//! them are drawn as finely as theirs, so that coarse discs do not hide fine ones. The
//! records are kept on the host too, 16 bytes a point, to be able to undo that.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use flaneur_scene::{Bounds3, PointChunk, PointNodeId, PointStations};
use glam::DVec3;

use crate::settings::SplatNormals;
use crate::{Gpu, RenderError, Settings};

mod draw_list;
mod evict;
mod kin;
mod pages;
mod record;
mod remote;
pub(crate) mod surveyed;

pub(crate) use draw_list::DrawList;
#[cfg(test)]
pub(crate) use draw_list::Drawn;
use kin::{Kin, ancestors};
use pages::{Pages, Part};
use record::{Drawable, Record, drawable, radius_code, set_radii};
pub(crate) use remote::Precedence;

/// Points of a block: one workgroup of the splat pass.
pub(crate) const BLOCK_POINTS: usize = 256;

/// All resident chunks.
#[derive(Debug)]
pub(crate) struct PointStore {
    pages: Pages,
    /// Ordered, so that ties of depth do not depend on the order of arrival.
    chunks: BTreeMap<PointNodeId, Chunk>,
    kin: Kin,
    blocks: u64,
    points: u64,
    /// Chunks whose records differ from the device's.
    stale: BTreeSet<PointNodeId>,
    pub(crate) refused: u64,
}

#[derive(Debug)]
struct Chunk {
    origin: DVec3,
    bounds: Bounds3,
    /// Distance between neighbouring points, metres.
    spacing_m: f32,
    radius_m: f32,
    records: Vec<Record>,
    /// The code of each record's radius, where nothing finer is around it.
    radii: Vec<u8>,
    /// Of each block of records, in the world.
    boxes: Vec<Bounds3>,
    /// Of each block of records, whence its points were taken, in the world.
    stations: Vec<Option<DVec3>>,
    /// All places from which the chunk's source was taken.
    places: Arc<[DVec3]>,
    /// Until they are on the device, which keeps them as they are.
    normals: Vec<u32>,
    parts: Vec<Part>,
}

/// Where points were lost and gained; boxes are empty where none were.
#[derive(Debug)]
pub(crate) struct Change {
    pub(crate) removed: Bounds3,
    pub(crate) added: Bounds3,
    /// Chunks that made room, with their boxes.
    pub(crate) evicted: Vec<(PointNodeId, Bounds3)>,
    /// Whether there was no room for the chunk.
    pub(crate) refused: bool,
}

impl Change {
    const NONE: Self = Self {
        removed: Bounds3::EMPTY,
        added: Bounds3::EMPTY,
        evicted: Vec::new(),
        refused: false,
    };
}

impl PointStore {
    pub(crate) fn new(normals: SplatNormals) -> Self {
        Self {
            pages: Pages::new(normals == SplatNormals::Estimated),
            chunks: BTreeMap::new(),
            kin: Kin::default(),
            blocks: 0,
            points: 0,
            stale: BTreeSet::new(),
            refused: 0,
        }
    }

    /// Adds a chunk, or replaces the one with the same identity.
    pub(crate) fn insert(
        &mut self,
        gpu: &Gpu,
        settings: &Settings,
        chunk: &PointChunk,
        eye: DVec3,
    ) -> Result<Change, RenderError> {
        check(chunk)?;
        let id = chunk.id;
        let radius = |spacing_m: f32| settings.splat_radius_m(spacing_m);
        let radius_m = radius(chunk.spacing_m);
        let drawable = drawable(chunk, radius, self.pages.with_normals());
        let Drawable { records, radii, normals, boxes, stations } = drawable;
        let blocks = boxes.len() as u64;
        let replaced = self.chunks.get(&id).map_or(0, |chunk| chunk.boxes.len() as u64);
        let most = settings.shares().points / self.pages.block_bytes();
        let lacking = (self.blocks - replaced + blocks).saturating_sub(most);
        let bounds = boxes.iter().fold(Bounds3::EMPTY, |all, block| all.union(block));
        let Some(less_useful) = self.less_useful(id, chunk.spacing_m, &bounds, eye, lacking) else {
            return Ok(Change { removed: self.remove(id), refused: true, ..Change::NONE });
        };
        let mut evicted = Vec::new();
        for id in less_useful {
            evicted.push((id, self.remove(id)));
        }
        let removed = self.remove(id);
        self.refused += (chunk.positions.len() - records.len()) as u64;
        if records.is_empty() {
            return Ok(Change { removed, evicted, ..Change::NONE });
        }
        self.blocks += blocks;
        self.points += records.len() as u64;
        // A page holds 2²¹ points, so blocks that fit its share fit a u32.
        let parts = self.pages.take(gpu, blocks as u32, most);
        let (origin, spacing_m) = (chunk.origin, chunk.spacing_m);
        let places = Arc::clone(&chunk.stations.places);
        let chunk = Chunk {
            origin,
            bounds,
            spacing_m,
            radius_m,
            records,
            radii,
            boxes,
            stations,
            places,
            normals,
            parts,
        };
        self.chunks.insert(id, chunk);
        self.kin.insert(id);
        self.stale.insert(id);
        self.refine(id, &Bounds3::EVERYWHERE);
        for above in ancestors(id) {
            self.refine(above, &bounds);
        }
        Ok(Change { removed, added: bounds, evicted, refused: false })
    }

    /// Removes a chunk; gives its box, empty where there was none.
    pub(crate) fn remove(&mut self, id: PointNodeId) -> Bounds3 {
        let Some(chunk) = self.chunks.remove(&id) else { return Bounds3::EMPTY };
        self.kin.remove(id);
        self.stale.remove(&id);
        self.blocks -= chunk.boxes.len() as u64;
        self.points -= chunk.records.len() as u64;
        for part in chunk.parts {
            self.pages.give_back(part);
        }
        for above in ancestors(id) {
            self.refine(above, &chunk.bounds);
        }
        chunk.bounds
    }

    /// Brings the device up to date.
    pub(crate) fn upload(&mut self, gpu: &Gpu) {
        for id in std::mem::take(&mut self.stale) {
            if let Some(chunk) = self.chunks.get_mut(&id) {
                self.pages.write_records(gpu, &chunk.parts, &chunk.records);
                let normals = std::mem::take(&mut chunk.normals);
                if !normals.is_empty() {
                    self.pages.write_normals(gpu, &chunk.parts, &normals);
                }
            }
        }
    }

    /// What is resident.
    pub(crate) fn bounds(&self) -> Bounds3 {
        self.chunks.values().fold(Bounds3::EMPTY, |all, chunk| all.union(&chunk.bounds))
    }

    /// The chunks that are resident.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = PointNodeId> + '_ {
        self.chunks.keys().copied()
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.pages.bytes()
    }

    pub(crate) fn point_count(&self) -> u64 {
        self.points
    }

    /// Records of a page, and codes of normals where points are drawn with them.
    pub(crate) fn page(&self, page: usize) -> (&wgpu::Buffer, Option<&wgpu::Buffer>) {
        self.pages.buffers(page)
    }

    /// Sets the radii of a chunk's points within a box from its own and those of the nodes
    /// below it.
    fn refine(&mut self, id: PointNodeId, within: &Bounds3) {
        if !self.chunks.contains_key(&id) {
            return;
        }
        let below: Vec<(Bounds3, u32)> = self
            .kin
            .below(id)
            .filter_map(|other| self.chunks.get(&other))
            .filter(|chunk| chunk.bounds.intersects(within))
            .map(|chunk| (chunk.bounds, radius_code(chunk.radius_m)))
            .collect();
        let Some(chunk) = self.chunks.get_mut(&id) else { return };
        if set_radii(&mut chunk.records, &chunk.radii, chunk.origin, within, &below) {
            self.stale.insert(id);
        }
    }
}

fn check(chunk: &PointChunk) -> Result<(), RenderError> {
    let positions = chunk.positions.len();
    let columns = [
        ("colours", chunk.colours.len()),
        ("normals", chunk.normals.len()),
        ("spacings", chunk.spacings_m.len()),
        ("stations", chunk.stations.of_points.len()),
    ];
    for (column, length) in columns {
        if length != 0 && length != positions {
            return Err(RenderError::PointColumns { id: chunk.id, positions, column, length });
        }
    }
    let PointStations { places, of_points } = &chunk.stations;
    let is_place =
        |&index: &u16| index == PointStations::UNKNOWN || usize::from(index) < places.len();
    if !(places.iter().all(|place| place.is_finite()) && of_points.iter().all(is_place)) {
        return Err(RenderError::PointStations { id: chunk.id, places: places.len() });
    }
    if !(chunk.spacing_m > 0.0 && chunk.spacing_m.is_finite() && chunk.origin.is_finite()) {
        return Err(RenderError::PointSpacing { id: chunk.id, spacing_m: chunk.spacing_m });
    }
    Ok(())
}

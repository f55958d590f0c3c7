//! What of the points one camera may see.
//!
//! Where that is more than a frame may draw, runs of points are left out, those whose points
//! appear closest together first: a threshold on how far apart they appear, so that what is
//! drawn changes block by block as the eye moves. Points above those that are left out take the
//! size of the finest that are drawn around them, so that no gap opens.

use std::ops::Range;

use flaneur_scene::{Bounds3, PointNodeId};
use glam::DVec3;

use super::remote::{Precedence, Remoteness};
use super::{BLOCK_POINTS, Chunk, PointStore};
use crate::frustum::Frustum;

/// Nearer than this a block does not appear any coarser, metres.
const NEAREST_M: f64 = 0.5;

/// A block to be drawn. Mirrors `Drawn` in splat/drawn.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Drawn {
    /// Its chunk's origin relative to the camera; then the radius of all its points in metres, 0
    /// where each has its own.
    pub(crate) placement: [f32; 4],
    /// Its number in its page, and the bits of the metres by which depths are pushed back where
    /// points are compared.
    pub(crate) block_behind: [u32; 2],
    pub(crate) padding: [u32; 2],
}

/// Blocks to be drawn for one camera, grouped by page.
#[derive(Debug, Default)]
pub(crate) struct DrawList {
    pub(crate) blocks: Vec<Drawn>,
    /// Page and its share of `blocks`.
    pub(crate) pages: Vec<(usize, Range<u32>)>,
    /// Points in the blocks.
    pub(crate) points: u64,
}

impl PointStore {
    /// What `frustum` may see, each point as large as what is resident around it allows; of the
    /// points about a share of 0 to 1.
    pub(crate) fn view_list(
        &self,
        frustum: &Frustum,
        centre: DVec3,
        share: f32,
        precedence: Precedence,
    ) -> DrawList {
        let remoteness = Remoteness::new(precedence, centre);
        let all = self.draw_list(frustum, centre, remoteness, |_, _| Some(0.0));
        if share >= 1.0 {
            return all;
        }
        let most = (all.points as f64 * f64::from(share)) as u64;
        self.thinned(frustum, centre, most, precedence)
    }

    /// What `frustum` may see of the chunks that `wanted` admits. Points have the size of
    /// their own chunk, at most `max_radius_m`, so that a map does not depend on the order
    /// in which chunks arrive.
    pub(crate) fn map_list(
        &self,
        frustum: &Frustum,
        centre: DVec3,
        max_radius_m: f32,
        precedence: Precedence,
        wanted: impl Fn(&PointNodeId) -> bool,
    ) -> DrawList {
        let remoteness = Remoteness::new(precedence, centre);
        self.draw_list(frustum, centre, remoteness, |id, chunk| {
            wanted(id).then_some(chunk.radius_m.min(max_radius_m))
        })
    }

    /// What `frustum` may see of the blocks whose points appear farthest apart.
    fn thinned(
        &self,
        frustum: &Frustum,
        centre: DVec3,
        most: u64,
        precedence: Precedence,
    ) -> DrawList {
        let mut remoteness = Remoteness::new(precedence, centre);
        let apart = |chunk: &Chunk, bounds: &Bounds3| {
            f64::from(chunk.spacing_m) / bounds.distance(centre).max(NEAREST_M)
        };
        let is_seen = |chunk: &Chunk, bounds| frustum.meets_box(bounds, f64::from(chunk.radius_m));
        let seen = || self.chunks.iter().filter(|(_, chunk)| is_seen(chunk, &chunk.bounds));
        let mut blocks: Vec<(f64, usize, u64)> = seen()
            .flat_map(|(_, chunk)| chunk.blocks().map(move |block| (chunk, block)))
            .filter(|(chunk, (_, bounds, _))| is_seen(chunk, bounds))
            .zip(0..)
            .map(|((chunk, (_, bounds, points)), index)| (apart(chunk, bounds), index, points))
            .collect();
        // Among equals the order of the chunks decides: coarse before fine.
        blocks.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut is_drawn = vec![false; blocks.len()];
        let (mut points, mut least_apart) = (0, f64::INFINITY);
        for (apart, index, of_block) in blocks {
            points += of_block;
            if points > most {
                break;
            }
            is_drawn[index] = true;
            least_apart = apart;
        }
        let mut is_drawn = is_drawn.into_iter();
        let mut list = Builder::new(self.pages.len());
        for (id, chunk) in seen() {
            let below: Vec<&Chunk> =
                self.kin.below(*id).filter_map(|id| self.chunks.get(&id)).collect();
            for ((place, bounds, points), station) in chunk.blocks().zip(&chunk.stations) {
                if !is_seen(chunk, bounds) || is_drawn.next() != Some(true) {
                    continue;
                }
                let Some(behind_m) = remoteness.behind(chunk, *station, bounds) else { continue };
                let around = below.iter().filter(|other| other.bounds.intersects(bounds));
                let (mut radius_m, mut complete) = (chunk.radius_m, true);
                for other in around {
                    if apart(other, bounds) >= least_apart {
                        radius_m = radius_m.min(other.radius_m);
                    } else {
                        complete = false;
                    }
                }
                // Where nothing is left out the points' own radii say more.
                let radius_m = if complete { 0.0 } else { radius_m };
                list.add(place, placement(chunk, centre, radius_m), behind_m, points);
            }
        }
        list.build()
    }

    fn draw_list(
        &self,
        frustum: &Frustum,
        centre: DVec3,
        mut remoteness: Remoteness,
        radius: impl Fn(&PointNodeId, &Chunk) -> Option<f32>,
    ) -> DrawList {
        let mut list = Builder::new(self.pages.len());
        for (id, chunk) in &self.chunks {
            let Some(radius_m) = radius(id, chunk) else { continue };
            let margin_m = f64::from(chunk.radius_m);
            if !frustum.meets_box(&chunk.bounds, margin_m) {
                continue;
            }
            let placement = placement(chunk, centre, radius_m);
            for ((place, bounds, points), station) in chunk.blocks().zip(&chunk.stations) {
                if !frustum.meets_box(bounds, margin_m) {
                    continue;
                }
                if let Some(behind_m) = remoteness.behind(chunk, *station, bounds) {
                    list.add(place, placement, behind_m, points);
                }
            }
        }
        list.build()
    }
}

impl Chunk {
    /// Page and block, box, and points of each block.
    fn blocks(&self) -> impl Iterator<Item = ((usize, u32), &Bounds3, u64)> {
        let places =
            self.parts.iter().flat_map(|part| part.blocks.clone().map(|block| (part.page, block)));
        places
            .zip(&self.boxes)
            .zip(self.block_sizes())
            .map(|((place, bounds), n)| (place, bounds, n))
    }

    fn block_sizes(&self) -> impl Iterator<Item = u64> {
        self.records.chunks(BLOCK_POINTS).map(|block| block.len() as u64)
    }
}

/// Of the blocks of a chunk, see [`Drawn`].
fn placement(chunk: &Chunk, centre: DVec3, radius_m: f32) -> [f32; 4] {
    (chunk.origin - centre).as_vec3().extend(radius_m).to_array()
}

/// A list that is being made.
struct Builder {
    list: DrawList,
    by_page: Vec<Vec<Drawn>>,
}

impl Builder {
    fn new(pages: usize) -> Self {
        Self { list: DrawList::default(), by_page: vec![Vec::new(); pages] }
    }

    fn add(
        &mut self,
        (page, block): (usize, u32),
        placement: [f32; 4],
        behind_m: f32,
        points: u64,
    ) {
        let block_behind = [block, behind_m.to_bits()];
        self.by_page[page].push(Drawn { placement, block_behind, padding: [0; 2] });
        self.list.points += points;
    }

    fn build(self) -> DrawList {
        let Self { mut list, by_page } = self;
        for (page, blocks) in by_page.into_iter().enumerate().filter(|(_, b)| !b.is_empty()) {
            let first = list.blocks.len() as u32;
            list.blocks.extend(blocks);
            list.pages.push((page, first..list.blocks.len() as u32));
        }
        list
    }
}

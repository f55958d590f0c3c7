//! What of the points one camera may see.

use std::ops::Range;

use flaneur_scene::PointNodeId;
use glam::DVec3;

use super::{BLOCK_POINTS, Chunk, PointStore};
use crate::frustum::Frustum;

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
    /// Points in the blocks.
    pub(crate) points: u64,
}

impl PointStore {
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
            let margin_m = f64::from(chunk.radius_m);
            if !frustum.meets_box(&chunk.bounds, margin_m) {
                continue;
            }
            let placement = list.placements.len() as u32;
            let [x, y, z] = (chunk.origin - centre).as_vec3().to_array();
            list.placements.push([x, y, z, radius_m]);
            let blocks = chunk
                .parts
                .iter()
                .flat_map(|part| part.blocks.clone().map(|block| (part.page, block)));
            let sizes = chunk.records.chunks(BLOCK_POINTS).map(<[_]>::len);
            for (((page, block), bounds), points) in blocks.zip(&chunk.boxes).zip(sizes) {
                if frustum.meets_box(bounds, margin_m) {
                    by_page[page].push([block, placement]);
                    list.points += points as u64;
                }
            }
        }
        for (page, blocks) in by_page.into_iter().enumerate().filter(|(_, b)| !b.is_empty()) {
            let first = list.blocks.len() as u32;
            list.blocks.extend(blocks);
            list.pages.push((page, first..list.blocks.len() as u32));
        }
        list
    }
}

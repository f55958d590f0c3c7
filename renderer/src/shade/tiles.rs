//! Which photographs can see something of which part of a picture.
//!
//! The picture is cut into tiles, and a photograph is drawn over those whose pyramid meets its
//! own: where it looks elsewhere it costs nothing.

use std::ops::Range;

use flaneur_scene::{Lens, View};
use glam::{DVec2, UVec2};

use crate::frustum::Frustum;
use crate::lens::{self, NOWHERE};
use crate::photographs::Photograph;
use crate::pinhole::Pinhole;

/// Pixels a side of a tile; `TILE` in photograph.wgsl. A multiple of the grid's step.
const TILE: u32 = 64;

/// The tiles, column and row, that each photograph can see something of: all of them, and each
/// photograph's share. `grid` is that of a distorted view.
pub(crate) fn lists(
    view: &View,
    grid: &[[f32; 2]],
    photographs: &[&Photograph],
) -> (Vec<[u32; 2]>, Vec<Range<u32>>) {
    let size = view.size();
    let mut tiles = Vec::new();
    for row in 0..size.y.div_ceil(TILE) {
        for column in 0..size.x.div_ceil(TILE) {
            let corner = UVec2::new(column, row) * TILE;
            if let Some(tile) = frustum(view, grid, corner, (corner + TILE).min(size)) {
                tiles.push(([column, row], tile));
            }
        }
    }
    let mut seen = Vec::new();
    let shares = photographs
        .iter()
        .map(|photograph| {
            let first = seen.len() as u32;
            let meets = |tile: &Frustum| photograph.frustum.meets(tile);
            seen.extend(tiles.iter().filter(|(_, tile)| meets(tile)).map(|(at, _)| *at));
            first..seen.len() as u32
        })
        .collect();
    (seen, shares)
}

/// What the pixels from `low` to `high` see; `None` where that is nothing.
fn frustum(view: &View, grid: &[[f32; 2]], low: UVec2, high: UVec2) -> Option<Frustum> {
    let (min, max) = extent(&view.camera.lens, grid, low, high);
    // Between the nodes of a grid a lens may bulge a little.
    let margin = 0.02 * (max - min) + 1e-6;
    let (min, max) = (min - margin, max + margin);
    let focal = 1.0 / (max - min);
    (focal.is_finite() && focal.min_element() > 0.0).then(|| {
        let pinhole = Pinhole { focal, centre: -min * focal, size: UVec2::ONE };
        Frustum::new(&view.camera, &pinhole)
    })
}

/// Normalised directions between which a tile lies.
fn extent(lens: &Lens, grid: &[[f32; 2]], low: UVec2, high: UVec2) -> (DVec2, DVec2) {
    if grid.is_empty() {
        let corner = |p: UVec2| lens.intrinsics.normalised_from_pixel(p.as_dvec2());
        return (corner(low), corner(high));
    }
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let row = lens::grid_size(lens.size).x;
    for y in low.y / lens::GRID_STEP..=high.y.div_ceil(lens::GRID_STEP) {
        for x in low.x / lens::GRID_STEP..=high.x.div_ceil(lens::GRID_STEP) {
            let Some(node) = grid.get((y * row + x) as usize) else { continue };
            if node[0] < NOWHERE {
                let m = DVec2::new(f64::from(node[0]), f64::from(node[1]));
                (min, max) = (min.min(m), max.max(m));
            }
        }
    }
    (min, max)
}

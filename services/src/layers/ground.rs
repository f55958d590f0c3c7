//! The ground as a GeoTIFF: one 32-bit height a grid node, in tiles, not compressed, so that a
//! reader fetches the bytes of a region and nothing else.
//!
//! Pixels are points (`GTRasterTypeGeoKey` 2): the tie point is the north-west node itself.
//! Unknown heights are NaN, which is also the nodata value. The uncertainty is an item of
//! the GDAL metadata.

mod read;
mod thin;
mod write;

use flaneur_scene::{Bounds3, GroundLayout};
use glam::{DVec2, DVec3};

pub use read::{GroundCursor, load, open};
pub use write::write;

/// Nodes along a side of a tile of the file.
const FILE_TILE: u32 = 64;

/// Cells along a side of a [`flaneur_scene::GroundTile`]: 65 × 65 nodes, borders shared.
const CELLS: u32 = 64;

// Whatever step is asked for, tiles share their border nodes.
const _: () = assert!(CELLS.is_multiple_of(flaneur_proto::MAX_GROUND_STEP));

/// The most nodes along a side of the grid.
pub const MAX_SIDE: u32 = 1 << 15;

/// The most nodes of a grid: 128 MiB of heights.
pub const MAX_NODES: u64 = 1 << 25;

/// GDAL's tag for an XML list of items.
const GDAL_METADATA: u16 = 42_112;

/// The item with the uncertainty.
const UNCERTAINTY: &str = "flaneur_uncertainty_m";

/// A grid of heights in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundGrid {
    /// World position of the south-west node, metres.
    pub origin: DVec2,
    /// Distance between nodes, metres, > 0.
    pub spacing_m: f64,
    /// Nodes a row (west to east), ≥ 2.
    pub columns: u32,
    /// Rows (south to north), ≥ 2.
    pub rows: u32,
    /// Heights in the world, metres, rows from south to north; NaN where unknown.
    pub heights: Vec<f32>,
    /// How far the heights may be off, metres.
    pub uncertainty_m: f64,
}

impl GroundGrid {
    /// The height at `p`, on the two triangles into which a mesh splits each cell (along its
    /// south-west to north-east diagonal); `None` outside of the grid and where a corner of the cell is
    /// unknown.
    pub fn height(&self, p: DVec2) -> Option<f64> {
        let at = (p - self.origin) / self.spacing_m;
        let limit = DVec2::new(f64::from(self.columns) - 1.0, f64::from(self.rows) - 1.0);
        if !(at.cmpge(DVec2::ZERO).all() && at.cmple(limit).all()) {
            return None;
        }
        let cell = at.floor().min(limit - 1.0).max(DVec2::ZERO);
        let (u, v) = (at - cell).into();
        let (c, r) = (cell.x as u32, cell.y as u32);
        let (sw, ne) = (self.node(c, r)?, self.node(c + 1, r + 1)?);
        let (se, nw) = (self.node(c + 1, r)?, self.node(c, r + 1)?);
        let height = if u >= v {
            sw + u * (se - sw) + v * (ne - se)
        } else {
            sw + v * (nw - sw) + u * (ne - nw)
        };
        height.is_finite().then_some(height)
    }

    /// How it is cut into tiles.
    pub fn layout(&self) -> GroundLayout {
        GroundLayout {
            origin: self.origin,
            tile_m: f64::from(CELLS) * self.spacing_m,
            columns: self.columns.saturating_sub(1).div_ceil(CELLS),
            rows: self.rows.saturating_sub(1).div_ceil(CELLS),
        }
    }

    /// The box around the known heights; empty where there are none.
    pub fn bounds(&self) -> Bounds3 {
        let mut bounds = Bounds3::EMPTY;
        for (i, height) in self.heights.iter().enumerate().filter(|(_, h)| h.is_finite()) {
            let (r, c) = (i as u32 / self.columns, i as u32 % self.columns);
            let plan = self.origin + DVec2::new(f64::from(c), f64::from(r)) * self.spacing_m;
            bounds.include(DVec3::new(plan.x, plan.y, f64::from(*height)));
        }
        bounds
    }

    fn node(&self, column: u32, row: u32) -> Option<f64> {
        let index = row as usize * self.columns as usize + column as usize;
        self.heights.get(index).map(|height| f64::from(*height))
    }
}

#[cfg(test)]
mod tests;

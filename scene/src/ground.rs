//! The terrain under the street: a grid of heights, in tiles.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::Bounds2;

/// A rectangle of grid nodes. Neighbouring tiles share their border nodes, so that
/// their meshes meet without a gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroundTile {
    /// Column and row of the tile in the scene's ground grid.
    pub index: (i32, i32),
    /// World position of the south-west node, metres.
    pub origin: DVec2,
    /// Distance between nodes, metres, > 0.
    pub spacing_m: f64,
    /// Nodes a row (west to east).
    pub columns: u32,
    /// Height in the world of each node, metres, rows from south to north;
    /// NaN where the terrain is not known.
    pub heights: Vec<f32>,
    /// How far the heights may be off, metres.
    pub uncertainty_m: f64,
}

/// How the terrain of a scene is cut into tiles: what there may be, before anything of it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroundLayout {
    /// South-west corner of tile (0, 0), world, metres.
    pub origin: DVec2,
    /// Length of a tile's side, metres, > 0. Those in the last column and row may be shorter.
    pub tile_m: f64,
    /// Tiles from west to east.
    pub columns: u32,
    /// Tiles from south to north.
    pub rows: u32,
}

impl GroundLayout {
    /// The tiles that meet `region`, row by row: column and row of each.
    pub fn tiles(&self, region: &Bounds2) -> impl Iterator<Item = (i32, i32)> + use<> {
        let cell = |p: DVec2| ((p - self.origin) / self.tile_m).floor();
        let nothing = region.is_empty();
        let range = |low: f64, high: f64, count: u32| {
            let count = f64::from(count.min(i32::MAX as u32));
            let (low, high) = (low.max(0.0), (high + 1.0).min(count));
            if low < high && !nothing { low as i32..high as i32 } else { 0..0 }
        };
        let (low, high) = (cell(region.min), cell(region.max));
        let columns = range(low.x, high.x, self.columns);
        let rows = range(low.y, high.y, self.rows);
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }

    /// The square of a tile.
    pub fn bounds(&self, (column, row): (i32, i32)) -> Bounds2 {
        let min = self.origin + DVec2::new(f64::from(column), f64::from(row)) * self.tile_m;
        Bounds2 { min, max: min + self.tile_m }
    }
}

impl GroundTile {
    /// Rows of nodes (south to north).
    pub fn rows(&self) -> u32 {
        u32::try_from(self.heights.len()).unwrap_or(0).checked_div(self.columns).unwrap_or(0)
    }

    /// The rectangle that the tile covers.
    pub fn bounds(&self) -> Bounds2 {
        let span = DVec2::new(
            f64::from(self.columns.saturating_sub(1)),
            f64::from(self.rows().saturating_sub(1)),
        );
        Bounds2 { min: self.origin, max: self.origin + span * self.spacing_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_those_that_meet_a_region() {
        let origin = DVec2::new(651_000.0, 6.86e6);
        let layout = GroundLayout { origin, tile_m: 64.0, columns: 3, rows: 2 };
        let around =
            |p: DVec2, half: f64| Bounds2 { min: origin + p - half, max: origin + p + half };
        let tiles = |region| layout.tiles(&region).collect::<Vec<_>>();
        assert_eq!(tiles(around(DVec2::new(70.0, 10.0), 1.0)), [(1, 0)]);
        assert_eq!(tiles(around(DVec2::new(64.0, 64.0), 1.0)), [(0, 0), (1, 0), (0, 1), (1, 1)]);
        assert_eq!(tiles(around(DVec2::ZERO, 1e9)).len(), 6);
        assert!(tiles(around(DVec2::splat(-100.0), 50.0)).is_empty());
        assert!(tiles(around(DVec2::NAN, 50.0)).is_empty() && tiles(Bounds2::EMPTY).is_empty());
        assert!(layout.bounds((1, 1)).min.distance(origin + 64.0) < 1e-9);
    }
}

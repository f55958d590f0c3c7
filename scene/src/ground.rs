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

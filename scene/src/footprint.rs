//! Building footprints: plan polygons with a base and a height.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::Bounds2;

/// A building as it was delivered: polygons with holes, to be extruded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Footprint {
    /// Identifier from the survey, or one made from its position in the file.
    pub id: String,
    /// Its polygons. Coordinates are those of the survey, unaltered.
    pub polygons: Vec<Polygon>,
    /// Height of its foot in the world, metres.
    pub base_m: f64,
    /// Height above its foot, metres, ≥ 0.
    pub height_m: f64,
    /// How far a wall may be from where the footprint puts it, metres.
    pub uncertainty_m: f64,
    /// Every attribute of the survey, a JSON object.
    pub attributes: String,
}

/// A polygon with holes: closed rings without the repeated last vertex.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Polygon {
    /// The outer ring first, then the holes.
    pub rings: Vec<Vec<DVec2>>,
}

impl Footprint {
    /// The rectangle around all polygons.
    pub fn bounds(&self) -> Bounds2 {
        let mut bounds = Bounds2::EMPTY;
        for point in self.polygons.iter().flat_map(|p| p.rings.iter().flatten()) {
            bounds.include(*point);
        }
        bounds
    }
}

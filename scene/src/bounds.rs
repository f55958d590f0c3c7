//! Axis-aligned boxes in the world frame, and regions of the plan.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// A rectangle of the plan, metres, world frame; empty where `min > max`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds2 {
    /// South-west corner.
    pub min: DVec2,
    /// North-east corner.
    pub max: DVec2,
}

/// A box, metres, world frame; empty where `min > max`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds3 {
    /// Lowest corner.
    pub min: DVec3,
    /// Highest corner.
    pub max: DVec3,
}

/// A part of the plan that a request asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// Everything.
    All,
    /// What meets this rectangle.
    Box(Bounds2),
    /// What meets the disc of `radius_m` around `centre`.
    Disc {
        /// Centre of the disc.
        centre: DVec2,
        /// Radius in metres.
        radius_m: f64,
    },
}

impl Bounds2 {
    /// The empty rectangle, neutral for [`Bounds2::include`].
    pub const EMPTY: Self = Self { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };

    /// Grows to hold `p`.
    pub fn include(&mut self, p: DVec2) {
        self.min = self.min.min(p);
        self.max = self.max.max(p);
    }

    /// Whether no point lies inside.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y)
    }

    /// Whether the two rectangles share a point, borders included.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Distance in metres from `p` to the nearest point of the rectangle, 0 inside.
    pub fn distance(&self, p: DVec2) -> f64 {
        p.distance(p.clamp(self.min, self.max))
    }
}

impl Bounds3 {
    /// The empty box, neutral for [`Bounds3::include`] and [`Bounds3::union`].
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box that contains every point.
    pub const EVERYWHERE: Self = Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

    /// Grows to hold `p`.
    pub fn include(&mut self, p: DVec3) {
        self.min = self.min.min(p);
        self.max = self.max.max(p);
    }

    /// Whether the two boxes share a point, borders included.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The smallest box that holds both.
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether no point lies inside.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The middle of the box.
    pub fn centre(&self) -> DVec3 {
        self.min.midpoint(self.max)
    }

    /// The box seen from above.
    pub fn plan(&self) -> Bounds2 {
        Bounds2 { min: self.min.truncate(), max: self.max.truncate() }
    }

    /// Distance in metres from `p` to the nearest point of the box, 0 inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        p.distance(p.clamp(self.min, self.max))
    }
}

impl Region {
    /// Whether anything of `bounds` lies in the region.
    pub fn meets(&self, bounds: &Bounds2) -> bool {
        match self {
            Self::All => true,
            Self::Box(b) => b.intersects(bounds),
            Self::Disc { centre, radius_m } => bounds.distance(*centre) <= *radius_m,
        }
    }

    /// The rectangle around the region, `None` for everything.
    pub fn bounds(&self) -> Option<Bounds2> {
        match *self {
            Self::All => None,
            Self::Box(b) => Some(b),
            Self::Disc { centre, radius_m } => {
                Some(Bounds2 { min: centre - radius_m, max: centre + radius_m })
            }
        }
    }
}

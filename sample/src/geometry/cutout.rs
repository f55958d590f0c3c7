//! Holes in sheets: railings and foliage, without a primitive for every bar and leaf.

use glam::{DVec2, DVec3};

use crate::look::noise::unit;

/// Which parts of a sheet are absent, by position on the sheet in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cutout {
    /// Nothing is absent.
    None,
    /// Upright bars with a rail at the top and the bottom.
    Railing {
        /// Height of the sheet.
        height_m: f64,
        /// Distance between bars.
        pitch_m: f64,
        /// Width of a bar, and height of a rail.
        bar_m: f64,
    },
    /// A handful of leaves on a disc.
    Leaves {
        /// Radius of the disc.
        radius_m: f64,
        /// Which handful.
        seed: u32,
    },
}

impl Cutout {
    const LEAVES: u32 = 9;

    /// Whether the sheet is whole.
    pub(crate) fn is_none(&self) -> bool {
        matches!(self, Self::None)
    }

    /// Whether the sheet is there at `local` (see [`super::Shape::local`]).
    pub(crate) fn is_present(&self, local: DVec3) -> bool {
        match *self {
            Self::None => true,
            Self::Railing { height_m, pitch_m, bar_m } => {
                let rail = local.y < 2.0 * bar_m || local.y > height_m - 1.6 * bar_m;
                rail || local.x.rem_euclid(pitch_m) < bar_m
            }
            Self::Leaves { radius_m, seed } => self.leaf(local.truncate(), radius_m, seed),
        }
    }

    /// Leaves are ellipses at random places on the disc, each pointing away from its middle.
    fn leaf(&self, p: DVec2, radius_m: f64, seed: u32) -> bool {
        (0..Self::LEAVES).any(|index| {
            let random = |n: u32| unit(seed, index * 4 + n);
            let angle = random(0) * std::f64::consts::TAU;
            let centre = DVec2::from_angle(angle) * (radius_m * 0.72 * random(1).sqrt());
            let axis = DVec2::from_angle(angle + 1.2 * (random(2) - 0.5));
            let d = p - centre;
            let (along, across) = (d.dot(axis), d.perp_dot(axis));
            let length = radius_m * (0.30 + 0.14 * random(3));
            (along / length).powi(2) + (across / (0.52 * length)).powi(2) < 1.0
        })
    }
}

//! Where the street lies in the world.
//!
//! The street frame has x along the street's axis, y to its left and z up, with its origin
//! on the axis at the start of the block; it is right-handed and in metres. Everything is
//! built and traced in it. The world is EPSG:2154 (Lambert-93): its coordinates are so far
//! from zero that single precision would be half a metre wide.

use flaneur_scene::world_from_rig;
use glam::{DMat3, DVec3};

/// The street's place in the world: a rotation about the vertical and a far translation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StreetFrame {
    origin: DVec3,
    heading: f64,
}

impl StreetFrame {
    /// The one place where every synthetic street lies: nowhere in particular, and askew to
    /// the grid so that no axis of the world is an axis of the street.
    pub(crate) const PLACE: Self =
        Self { origin: DVec3::new(651_482.35, 6_861_037.6, 41.2), heading: 0.61 };

    /// Heading of the street's axis, clockwise from grid north, radians.
    pub(crate) fn heading(&self) -> f64 {
        self.heading
    }

    /// Rotation from the street frame to the world.
    pub(crate) fn world_from_street(&self) -> DMat3 {
        // A rig that looks along the street has y forward and x right: x of the street is
        // its y, y of the street its −x.
        let rig_from_street = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        world_from_rig(self.heading, 0.0, 0.0) * rig_from_street
    }

    /// World position of a point of the street.
    pub(crate) fn world_from_point(&self, p_street: DVec3) -> DVec3 {
        self.origin + self.world_from_street() * p_street
    }

    /// The point of the street at a world position.
    pub(crate) fn point_from_world(&self, p_world: DVec3) -> DVec3 {
        self.world_from_street().transpose() * (p_world - self.origin)
    }
}

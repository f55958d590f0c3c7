//! The growing list of primitives, and the local frame in which parts are placed.

use glam::{DMat3, DVec3};

use super::Class;
use crate::geometry::{Cutout, Primitive, Shape};
use crate::look::Material;

/// A kind of surface: what it is and what it looks like.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// What it is.
    pub(crate) class: Class,
    /// What it looks like.
    pub(crate) material: Material,
}

/// Primitives and surfaces while a street is built.
#[derive(Debug, Default)]
pub(crate) struct Model {
    /// All primitives.
    pub(crate) primitives: Vec<Primitive>,
    /// The surfaces that they name.
    pub(crate) surfaces: Vec<Surface>,
}

/// A frame for parts: `along` to the right of someone who faces the part, `out` towards
/// that person, up. Both are horizontal unit vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// The left foot of the part, street frame.
    pub(crate) origin: DVec3,
    /// To the right.
    pub(crate) along: DVec3,
    /// Towards the viewer.
    pub(crate) out: DVec3,
}

impl Model {
    /// Registers a surface.
    pub(crate) fn surface(&mut self, class: Class, material: Material) -> u32 {
        self.surfaces.push(Surface { class, material });
        u32::try_from(self.surfaces.len() - 1).expect("fewer than 2^32 surfaces")
    }

    /// Adds a whole shape.
    pub(crate) fn push(&mut self, shape: Shape, surface: u32) {
        self.primitives.push(Primitive { shape, surface, cutout: Cutout::None });
    }

    /// Adds a sheet with holes.
    pub(crate) fn push_cut(&mut self, shape: Shape, surface: u32, cutout: Cutout) {
        self.primitives.push(Primitive { shape, surface, cutout });
    }

    /// Adds an upright tube of constant radius.
    pub(crate) fn post(&mut self, foot: DVec3, height_m: f64, radius: f64, surface: u32) {
        let axis = DVec3::Z * height_m;
        let shape = Shape::Tube { base: foot, axis, base_radius: radius, top_radius: radius };
        self.push(shape, surface);
    }
}

impl Place {
    /// The place at `origin` whose viewer stands towards `out` (horizontal, unit).
    pub(crate) fn facing(origin: DVec3, out: DVec3) -> Self {
        Self { origin, along: (-out).cross(DVec3::Z), out }
    }

    /// The place shifted by (along, out, up).
    pub(crate) fn moved(&self, along: f64, out: f64, up: f64) -> Self {
        Self { origin: self.at(along, out, up), ..*self }
    }

    /// Street position of (along, out, up).
    pub(crate) fn at(&self, along: f64, out: f64, up: f64) -> DVec3 {
        self.origin + self.vector(along, out, up)
    }

    /// Street direction of (along, out, up).
    pub(crate) fn vector(&self, along: f64, out: f64, up: f64) -> DVec3 {
        DMat3::from_cols(self.along, self.out, DVec3::Z) * DVec3::new(along, out, up)
    }

    /// The box between two corners (along, out, up), for places along the axes.
    pub(crate) fn block(&self, low: [f64; 3], high: [f64; 3]) -> Shape {
        let (a, b) = (self.at(low[0], low[1], low[2]), self.at(high[0], high[1], high[2]));
        Shape::Block { min: a.min(b), max: a.max(b) }
    }

    /// The upright sheet that faces the viewer, from its lower left corner.
    pub(crate) fn pane(&self, corner: [f64; 3], width_m: f64, height_m: f64) -> Shape {
        Shape::Sheet {
            corner: self.at(corner[0], corner[1], corner[2]),
            u: self.along * width_m,
            v: DVec3::Z * height_m,
        }
    }

    /// The parallelogram with sides `u` and `v`, all as (along, out, up).
    pub(crate) fn sheet(&self, corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Shape {
        Shape::Sheet {
            corner: self.at(corner[0], corner[1], corner[2]),
            u: self.vector(u[0], u[1], u[2]),
            v: self.vector(v[0], v[1], v[2]),
        }
    }
}

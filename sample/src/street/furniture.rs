//! Lamp posts, signs, bollards and bins.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Class;
use super::model::{Model, Place};
use crate::geometry::Shape;
use crate::look::Material;

/// The surfaces that all street furniture shares.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Furniture {
    iron: u32,
    lamp: u32,
    galvanised: u32,
    red: u32,
    white: u32,
    blue: u32,
    green: u32,
}

impl Furniture {
    /// Registers the surfaces.
    pub(crate) fn new(model: &mut Model) -> Self {
        let mut painted = |r: f64, g: f64, b: f64| {
            let colour = DVec3::new(r, g, b);
            model.surface(Class::Furniture, Material::Paintwork { colour })
        };
        Self {
            iron: painted(0.03, 0.05, 0.045),
            lamp: painted(0.75, 0.74, 0.68),
            galvanised: painted(0.33, 0.34, 0.35),
            red: painted(0.45, 0.02, 0.02),
            white: painted(0.72, 0.72, 0.72),
            blue: painted(0.02, 0.08, 0.35),
            green: painted(0.04, 0.14, 0.07),
        }
    }

    /// A lamp post whose arm reaches over the road.
    pub(crate) fn lamp_post(&self, model: &mut Model, place: &Place) {
        let foot = place.at(0.0, 0.0, -0.1);
        model.post(foot, 0.9, 0.09, self.iron);
        let shaft = DVec3::Z * 6.6;
        model.push(
            Shape::Tube { base: foot, axis: shaft, base_radius: 0.065, top_radius: 0.042 },
            self.iron,
        );
        let top = foot + shaft;
        let arm = place.vector(0.0, 1.1, 0.28);
        model.push(
            Shape::Tube {
                base: top - DVec3::Z * 0.12,
                axis: arm,
                base_radius: 0.032,
                top_radius: 0.028,
            },
            self.iron,
        );
        let head = top + arm + place.vector(0.0, 0.12, -0.1);
        let radii = place.vector(0.17, 0.4, 0.085).abs();
        model.push(Shape::Ellipsoid { centre: head, radii }, self.iron);
        let glass = head - DVec3::Z * 0.05;
        model.push(Shape::Ellipsoid { centre: glass, radii: radii * 0.8 }, self.lamp);
    }

    /// A traffic sign that faces `place.out`: no parking, or a pedestrian crossing.
    pub(crate) fn sign(&self, model: &mut Model, place: &Place, crossing: bool) {
        model.post(place.at(0.0, 0.0, -0.1), 2.75, 0.032, self.galvanised);
        let disc = |model: &mut Model, out: f64, radius: f64, surface: u32| {
            let centre = place.at(0.0, out, 2.35);
            model.push(Shape::Disc { centre, normal: place.out, radius }, surface);
        };
        disc(model, 0.036, 0.31, self.galvanised);
        if crossing {
            let board = |model: &mut Model, out: f64, size: DVec2, surface: u32| {
                let corner = [-0.5 * size.x, out, 2.35 - 0.5 * size.y];
                model.push(place.pane(corner, size.x, size.y), surface);
            };
            board(model, 0.040, DVec2::splat(0.62), self.blue);
            board(model, 0.044, DVec2::splat(0.34), self.white);
        } else {
            disc(model, 0.040, 0.305, self.red);
            disc(model, 0.044, 0.235, self.blue);
            let bar = place.sheet([-0.20, 0.048, 2.50], [0.05, 0.0, 0.05], [0.34, 0.0, -0.34]);
            model.push(bar, self.red);
        }
    }

    /// A bollard.
    pub(crate) fn bollard(&self, model: &mut Model, foot: DVec3) {
        model.post(foot - DVec3::Z * 0.1, 0.95, 0.05, self.iron);
        let ring = Shape::Tube {
            base: foot + DVec3::Z * 0.66,
            axis: DVec3::Z * 0.08,
            base_radius: 0.054,
            top_radius: 0.054,
        };
        model.push(ring, self.white);
        let centre = foot + DVec3::Z * 0.86;
        model.push(Shape::Ellipsoid { centre, radii: DVec3::splat(0.07) }, self.iron);
    }

    /// A wheeled bin in front of a house.
    pub(crate) fn bin(&self, model: &mut Model, place: &Place, rng: &mut ChaCha8Rng) {
        let colour = [self.green, self.galvanised, self.blue][rng.random_range(0..3)];
        model.push(place.block([-0.26, -0.3, 0.06], [0.26, 0.28, 0.92]), colour);
        model.push(place.block([-0.29, -0.34, 0.92], [0.29, 0.33, 0.99]), colour);
        for along in [-0.28, 0.2] {
            let base = place.at(along, -0.22, 0.1);
            let axis = place.vector(0.08, 0.0, 0.0);
            model.push(Shape::Tube { base, axis, base_radius: 0.1, top_radius: 0.1 }, self.iron);
        }
    }
}

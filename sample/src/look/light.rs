//! Light from the sky and from the street itself, gathered once on a grid.
//!
//! Every node of the grid holds the light that arrives from each of the six axis
//! directions (an ambient cube), sky and one bounce of sunlight included. Surfaces
//! interpolate it a little in front of themselves. It is smooth and the same from every
//! viewpoint, at a fraction of the rays that gathering per pixel would take.

use flaneur_scene::Bounds3;
use glam::{DVec3, UVec3};
use rayon::prelude::*;

use super::material::Spot;
use super::sky::{SUN, sky, towards_sun};
use crate::geometry::Ray;
use crate::street::{FACADE_M, Street};

const SPACING: DVec3 = DVec3::new(1.6, 1.0, 1.3);
const RAYS: u32 = 64;
/// Shade where the grid knows nothing: inside solids and behind the houses.
const ELSEWHERE: DVec3 = DVec3::new(0.21, 0.215, 0.225);

/// The grid.
#[derive(Debug)]
pub(crate) struct Light {
    origin: DVec3,
    counts: UVec3,
    /// Six colours a node, for light from +x, −x, +y, −y, +z, −z; `None` inside solids.
    nodes: Vec<Option<[DVec3; 6]>>,
}

impl Light {
    /// Gathers the light of a street.
    pub(crate) fn gather(street: &Street) -> Self {
        let top = street.tree.bounds().max.z;
        let bounds = Bounds3 {
            min: DVec3::new(-16.0, -FACADE_M - 1.5, street.terrain.axis(0.0).min(0.0) - 1.0),
            max: DVec3::new(street.length_m + 16.0, FACADE_M + 1.5, top + 2.0),
        };
        let counts = ((bounds.max - bounds.min) / SPACING).ceil().as_uvec3() + 1;
        let mut light = Self { origin: bounds.min, counts, nodes: Vec::new() };
        let layer = counts.x * counts.y;
        light.nodes = (0..layer * counts.z)
            .into_par_iter()
            .map(|i| {
                let at = UVec3::new(i % counts.x, i / counts.x % counts.y, i / layer);
                gather_at(street, light.origin + at.as_dvec3() * SPACING)
            })
            .collect();
        light
    }

    /// Light on a surface at `position` with unit normal `normal`, sunlight excluded,
    /// divided by π: what a white surface there would send back.
    pub(crate) fn ambient(&self, position: DVec3, normal: DVec3) -> DVec3 {
        let at = (position + normal * 0.55 - self.origin) / SPACING;
        let last = self.counts.as_dvec3() - 1.001;
        let at = at.clamp(DVec3::ZERO, last);
        let base = at.floor();
        let f = at - base;
        let base = base.as_uvec3();
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for corner in 0..8u32 {
            let step = UVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let w = DVec3::select(step.cmpeq(UVec3::ONE), f, 1.0 - f);
            let weight = w.x * w.y * w.z;
            let n = base + step;
            let index = n.x + self.counts.x * (n.y + self.counts.y * n.z);
            if let Some(cube) = &self.nodes[index as usize] {
                sum += weight * evaluate(cube, normal);
                total += weight;
            }
        }
        if total > 0.02 { sum / total } else { ELSEWHERE }
    }
}

/// Squared components of the normal weigh the three sides that it faces.
fn evaluate(cube: &[DVec3; 6], normal: DVec3) -> DVec3 {
    let squared = normal * normal;
    (0..3).map(|axis| cube[2 * axis + usize::from(normal[axis] < 0.0)] * squared[axis]).sum()
}

fn gather_at(street: &Street, position: DVec3) -> Option<[DVec3; 6]> {
    let mut cube = [(DVec3::ZERO, 0.0); 6];
    let mut inside = 0;
    for i in 0..RAYS {
        // Fibonacci's lattice on the sphere.
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(RAYS);
        let angle = f64::from(i) * 2.399_963_229_728_653;
        let across = (1.0 - z * z).sqrt();
        let direction = DVec3::new(across * angle.cos(), across * angle.sin(), z);
        let ray = Ray { origin: position, direction };
        let light = match street.tree.nearest(&ray, 200.0) {
            None => sky(direction),
            Some(hit) => {
                let facing = hit.contact.normal.dot(direction);
                if facing > 0.0 && hit.contact.distance < 6.0 {
                    inside += 1;
                }
                bounce(street, &ray, &hit)
            }
        };
        for (side, (sum, total)) in cube.iter_mut().enumerate() {
            let axis = direction[side / 2] * if side % 2 == 0 { 1.0 } else { -1.0 };
            if axis > 0.0 {
                *sum += light * axis;
                *total += axis;
            }
        }
    }
    (inside < RAYS / 3).then(|| cube.map(|(sum, total)| sum / total))
}

/// What a surface sends on: its albedo times the sun, where the sun reaches it, and a
/// share of skylight that stands for all further bounces.
fn bounce(street: &Street, ray: &Ray, hit: &crate::geometry::Hit) -> DVec3 {
    let contact = hit.contact;
    let position = ray.at(contact.distance);
    let normal =
        if contact.normal.dot(ray.direction) > 0.0 { -contact.normal } else { contact.normal };
    let primitive = street.tree.primitive(hit.primitive);
    let spot = Spot {
        position,
        local: primitive.shape.local(position),
        normal,
        direction: ray.direction,
        footprint_m: 0.5,
    };
    let albedo = street.surface(hit).material.appearance(&spot).albedo;
    let sun = towards_sun();
    let facing = normal.dot(sun).max(0.0);
    let shadow = Ray { origin: position + normal * 1e-4, direction: sun };
    let lit = facing > 0.0 && !street.tree.is_blocked(&shadow, 200.0);
    let ambient = ELSEWHERE * (0.9 + 0.5 * normal.z);
    albedo * (ambient + if lit { SUN * facing } else { DVec3::ZERO })
}

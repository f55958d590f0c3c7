//! Street trees: a trunk, branches, and leaves by the handful.

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Class;
use super::model::Model;
use crate::geometry::{Cutout, Shape};
use crate::look::Material;

const BLOBS: u32 = 22;
const HANDFULS: u32 = 62;

/// Plants a tree.
pub(crate) fn plant(model: &mut Model, foot: DVec3, rng: &mut ChaCha8Rng) {
    let bark = model.surface(Class::Vegetation, Material::Bark { seed: rng.random() });
    let fork = rng.random_range(2.3..2.9);
    let lean = DVec3::new(rng.random_range(-0.12..0.12), rng.random_range(-0.12..0.12), fork);
    let girth = rng.random_range(0.11..0.17);
    model.push(
        Shape::Tube {
            base: foot - DVec3::Z * 0.2,
            axis: lean + DVec3::Z * 0.2,
            base_radius: girth * 1.2,
            top_radius: girth * 0.85,
        },
        bark,
    );
    let fork = foot + lean;
    let radii = DVec3::new(1.75, 1.75, 2.1) * rng.random_range(0.85..1.1);
    let middle = fork + DVec3::Z * (0.8 * radii.z);
    let green = DVec3::new(0.085, 0.145, 0.035)
        * DVec3::new(rng.random_range(0.8..1.5), rng.random_range(0.85..1.15), 1.0);
    for _ in 0..BLOBS {
        let centre = middle + direction(rng) * radii * rng.random_range(0.35..0.85);
        branch(model, fork, centre, girth, bark);
        let radius = rng.random_range(0.5..0.95);
        let tint = green * rng.random_range(0.8..1.25);
        let leaf = model.surface(Class::Vegetation, Material::Leaf { colour: tint });
        for _ in 0..HANDFULS {
            let offset = direction(rng);
            let reach = radius * rng.random_range(0.45f64..1.0).sqrt();
            let handful = rng.random_range(0.17..0.27);
            // Leaves lie roughly along the blob's surface, facing outward and up.
            let normal =
                (offset + direction(rng) * 0.9 + DVec3::Z * 0.3).try_normalize().unwrap_or(offset);
            model.push_cut(
                Shape::Disc { centre: centre + offset * reach, normal, radius: handful },
                leaf,
                Cutout::Leaves { radius_m: handful, seed: rng.random() },
            );
        }
    }
}

fn branch(model: &mut Model, fork: DVec3, tip: DVec3, girth: f64, bark: u32) {
    let base = fork - DVec3::Z * 0.1;
    model.push(
        Shape::Tube { base, axis: tip - base, base_radius: 0.45 * girth, top_radius: 0.015 },
        bark,
    );
}

/// A uniformly distributed direction.
fn direction(rng: &mut ChaCha8Rng) -> DVec3 {
    let z: f64 = rng.random_range(-1.0..1.0);
    let angle = rng.random_range(0.0..std::f64::consts::TAU);
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * angle.cos(), across * angle.sin(), z)
}

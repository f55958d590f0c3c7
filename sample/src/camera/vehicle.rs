//! The vehicle under the rig, which every camera but the upper one sees.

use glam::{DMat3, DVec3};

use crate::geometry::{Ray, Shape};
use crate::look::Light;

/// The car below the rig, in the rig frame: roof, bonnet and boot.
const PARTS: [[[f64; 3]; 2]; 3] = [
    [[-0.78, -2.1, -1.3], [0.78, 1.05, -0.95]],
    [[-0.84, 1.05, -1.9], [0.84, 2.25, -1.45]],
    [[-0.84, -2.5, -1.9], [0.84, -2.1, -1.4]],
];

/// The radiance of the vehicle where `ray` (rig frame) meets it; `None` where it does not.
///
/// `street_from_rig` places the rig for the light; nothing of the street shades it.
pub(crate) fn vehicle(
    ray: &Ray,
    light: &Light,
    position: DVec3,
    street_from_rig: DMat3,
) -> Option<DVec3> {
    let contact = nearest(ray)?;
    let normal = street_from_rig * contact.1;
    let reflected = street_from_rig * ray.direction.reflect(contact.1);
    let paint = DVec3::new(0.055, 0.06, 0.07) * light.ambient(position, normal);
    Some(paint + 0.09 * light.ambient(position + reflected * 3.0, reflected))
}

/// Whether `ray` (rig frame) meets the vehicle.
pub(crate) fn hides(ray: &Ray) -> bool {
    nearest(ray).is_some()
}

fn nearest(ray: &Ray) -> Option<(f64, DVec3)> {
    PARTS
        .iter()
        .filter_map(|[min, max]| {
            let shape = Shape::Block { min: DVec3::from_array(*min), max: DVec3::from_array(*max) };
            shape.intersect(ray, f64::INFINITY)
        })
        .map(|contact| (contact.distance, contact.normal))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

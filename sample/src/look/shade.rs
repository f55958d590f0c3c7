//! The colour that a ray brings back.

use glam::DVec3;

use super::light::Light;
use super::material::{Appearance, Spot};
use super::sky::{SUN, sky, towards_sun};
use crate::geometry::{Hit, Ray};
use crate::street::Street;

/// No ray sees farther.
pub(crate) const FAR_M: f64 = 1000.0;

/// A street and its light, ready to be looked at.
#[derive(Debug)]
pub(crate) struct Shader<'a> {
    /// The street.
    pub(crate) street: &'a Street,
    /// Its light.
    pub(crate) light: &'a Light,
}

impl Shader<'_> {
    /// The nearest surface along a ray.
    pub(crate) fn nearest(&self, ray: &Ray) -> Option<Hit> {
        self.street.tree.nearest(ray, FAR_M)
    }

    /// Radiance that arrives along `ray`, which meets `hit`. `spread` is the angle of a
    /// pixel in radians.
    pub(crate) fn radiance(&self, ray: &Ray, hit: Option<&Hit>, spread: f64) -> DVec3 {
        self.bounced(ray, hit, spread, 1)
    }

    fn bounced(&self, ray: &Ray, hit: Option<&Hit>, spread: f64, bounces: u32) -> DVec3 {
        let Some(hit) = hit else { return sky(ray.direction) };
        let distance = hit.contact.distance;
        let position = ray.at(distance);
        let outward = hit.contact.normal;
        let normal = if outward.dot(ray.direction) > 0.0 { -outward } else { outward };
        let grazing = (-normal.dot(ray.direction)).max(0.15);
        let spot = Spot {
            position,
            local: self.street.tree.primitive(hit.primitive).shape.local(position),
            normal,
            direction: ray.direction,
            // Between the short and the long axis of the pixel's ellipse on the surface.
            footprint_m: spread * distance / grazing.sqrt(),
        };
        let surface = self.street.surface(hit);
        let look = surface.material.appearance(&spot);
        let leaning = tilted(normal, look.tilt);
        let mut colour = look.albedo * self.diffuse(&spot, leaning, &look);
        if look.gloss > 0.0 {
            let cosine = (-leaning.dot(ray.direction)).clamp(0.0, 1.0);
            // Schlick's approximation.
            let mirror = look.gloss + (1.0 - look.gloss) * (1.0 - cosine).powi(5);
            let reflected = self.reflection(
                ray,
                position,
                normal,
                leaning,
                look.gloss,
                spread * distance,
                bounces,
            );
            colour = colour * (1.0 - mirror) + reflected * mirror;
        }
        // A trace of haze gives depth to the far end.
        let haze = 1.0 - (-distance / 900.0).exp();
        colour.lerp(DVec3::new(0.55, 0.63, 0.72), haze)
    }

    fn diffuse(&self, spot: &Spot, normal: DVec3, look: &Appearance) -> DVec3 {
        let mut light = self.light.ambient(spot.position, normal);
        let sun = towards_sun();
        let facing = normal.dot(sun);
        let front = facing.max(0.0) * (1.0 - 0.5 * look.translucency);
        let back = (-facing).max(0.0) * look.translucency;
        if front + back > 0.0 {
            let side = spot.normal * spot.normal.dot(sun).signum();
            let shadow = Ray { origin: spot.position + side * 1e-4, direction: sun };
            if !self.street.tree.is_blocked(&shadow, FAR_M) {
                light += SUN * (front + back);
            }
        }
        light
    }

    #[expect(clippy::too_many_arguments, reason = "the state of one bounce")]
    fn reflection(
        &self,
        ray: &Ray,
        position: DVec3,
        normal: DVec3,
        leaning: DVec3,
        gloss: f64,
        width_m: f64,
        bounces: u32,
    ) -> DVec3 {
        let direction = ray.direction.reflect(leaning).normalize();
        if direction.dot(normal) <= 0.0 {
            return DVec3::ZERO;
        }
        if gloss < 0.04 || bounces == 0 {
            // A dull coat reflects a blur: the light of that side will do.
            return self.light.ambient(position, direction);
        }
        let mirrored = Ray { origin: position + normal * 1e-4, direction };
        let hit = self.street.tree.nearest(&mirrored, FAR_M);
        // The mirrored pixel has the width that it had on the mirror, and grows.
        let spread = hit.map_or(0.01, |hit| 0.004 + width_m / hit.contact.distance.max(0.1));
        self.bounced(&mirrored, hit.as_ref(), spread, bounces - 1)
    }
}

/// The normal leaned by `tilt` along the two horizontal-first axes of its surface.
fn tilted(normal: DVec3, tilt: glam::DVec2) -> DVec3 {
    if tilt == glam::DVec2::ZERO {
        return normal;
    }
    let right = DVec3::Z.cross(normal).try_normalize().unwrap_or(DVec3::X);
    let up = normal.cross(right);
    (normal - right * tilt.x - up * tilt.y).normalize()
}

//! Sun and sky.

use glam::{DVec2, DVec3};

use super::noise::{fractal, smooth};

/// Irradiance of the sun on a surface that faces it, divided by π.
pub(crate) const SUN: DVec3 = DVec3::new(0.80, 0.73, 0.61);

/// Direction towards the sun in the street frame: 50° up, over the right-hand roofs, so
/// that the left facades are lit and part of the road lies in shade.
pub(crate) fn towards_sun() -> DVec3 {
    DVec3::new(0.46, -0.44, 0.77).normalize()
}

/// Radiance of the sky in a direction (unit), clouds included, the sun's disc excluded.
pub(crate) fn sky(direction: DVec3) -> DVec3 {
    let up = direction.z.max(0.0);
    let zenith = DVec3::new(0.15, 0.28, 0.54);
    let horizon = DVec3::new(0.66, 0.72, 0.78);
    let clear = horizon.lerp(zenith, up.powf(0.55));
    let sun = direction.dot(towards_sun()).max(0.0);
    let glow = DVec3::new(1.0, 0.9, 0.75) * (0.25 * sun.powi(8) + 0.5 * sun.powi(90));
    let plane = direction.truncate() / (up + 0.12);
    let puff = fractal(plane, 1.6, 6, 0.0, 41)
        + 0.35 * fractal(plane + DVec2::splat(7.0), 5.0, 2, 0.0, 42);
    let cover = smooth(-0.05, 0.30, puff) * smooth(0.0, 0.12, up);
    // Thick parts are grey below, thin edges bright.
    let cloud = DVec3::splat(0.98) - DVec3::new(0.30, 0.28, 0.24) * smooth(0.25, 0.7, puff);
    (clear + glow).lerp(cloud + 0.3 * glow, 0.88 * cover)
}

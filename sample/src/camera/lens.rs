//! Directions of pixels, fast: the lens of every pixel of every photograph is inverted.

use flaneur_scene::{Distortion, Lens};
use glam::{DVec2, DVec3};

/// The inverse of a lens, with what does not depend on the pixel computed once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unprojector {
    lens: Lens,
    limit_px: f64,
}

impl Unprojector {
    /// The inverse of `lens`, a pinhole with or without radial distortion in pixels.
    pub(crate) fn new(lens: Lens) -> Self {
        Self { lens, limit_px: lens.distortion.limit() }
    }

    /// The direction (x/z, y/z, 1) that a raw pixel sees, as [`Lens::unproject`] gives it.
    pub(crate) fn direction(&self, pixel: DVec2) -> Option<DVec3> {
        let Distortion::RadialPixels { centre, k, .. } = self.lens.distortion else {
            return self.lens.unproject(pixel);
        };
        let v = pixel - centre;
        let raw = v.length();
        let mut r = raw;
        // Newton: below the limit the radius grows, and these lenses bend it gently.
        for _ in 0..12 {
            let s = r * r;
            let error = r * (1.0 + s * (k[0] + s * (k[1] + s * k[2]))) - raw;
            r -= error / (1.0 + s * (3.0 * k[0] + s * (5.0 * k[1] + s * 7.0 * k[2])));
            if error.abs() < 1e-12 * (1.0 + raw) {
                break;
            }
        }
        if !(r < self.limit_px) {
            return None;
        }
        let ideal = if raw > 0.0 { centre + v * (r / raw) } else { pixel };
        Some(self.lens.intrinsics.normalised_from_pixel(ideal).extend(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Rig;

    /// The shortcut gives what the reference gives: to 1e-10 in normalised units, the
    /// precision that the reference itself states.
    #[test]
    fn agrees_with_the_reference() {
        for camera in Rig::survey().cameras {
            let lens = camera.lens.scaled_to(glam::UVec2::splat(256));
            let fast = Unprojector::new(lens);
            for i in 0..400 {
                let pixel = DVec2::new(f64::from(i % 20), f64::from(i / 20)) * 13.4 + 0.5;
                match (fast.direction(pixel), lens.unproject(pixel)) {
                    (Some(a), Some(b)) => assert!(a.distance(b) < 1e-10, "{pixel}: {a} {b}"),
                    (a, b) => assert_eq!(a, b, "{pixel}"),
                }
            }
        }
    }
}

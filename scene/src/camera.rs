//! Pinhole cameras with lens distortion, and cameras placed in the world.

use glam::{DMat3, DVec2, DVec3, UVec2};
use serde::{Deserialize, Serialize};

use crate::Distortion;

/// A pinhole: `u = fx x/z + cx`, `v = fy y/z + cy`, all in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// Focal length along x.
    pub fx: f64,
    /// Focal length along y.
    pub fy: f64,
    /// Principal point, x.
    pub cx: f64,
    /// Principal point, y.
    pub cy: f64,
}

/// Intrinsics, distortion and image size that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lens {
    /// Image size in pixels to which the other fields refer.
    pub size: UVec2,
    /// The ideal pinhole.
    pub intrinsics: Intrinsics,
    /// The departure from it.
    pub distortion: Distortion,
}

/// A lens placed in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PosedCamera {
    /// Centre of projection, world frame, metres.
    pub centre: DVec3,
    /// Rotation: `p_cam = cam_from_world (P − centre)`.
    pub cam_from_world: DMat3,
    /// The lens.
    pub lens: Lens,
}

impl Intrinsics {
    /// The pinhole with square pixels whose vertical field of view is `fov_y` radians.
    pub fn from_fov_y(fov_y: f64, size: UVec2) -> Self {
        let size = size.as_dvec2();
        let focal = 0.5 * size.y / (0.5 * fov_y).tan();
        Self { fx: focal, fy: focal, cx: 0.5 * size.x, cy: 0.5 * size.y }
    }

    /// Ideal pixel of a normalised position (x/z, y/z).
    pub fn pixel_from_normalised(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.fx * p.x + self.cx, self.fy * p.y + self.cy)
    }

    /// Normalised position (x/z, y/z) of an ideal pixel.
    pub fn normalised_from_pixel(&self, pixel: DVec2) -> DVec2 {
        DVec2::new((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy)
    }
}

impl Lens {
    /// A pinhole without distortion.
    pub fn pinhole(size: UVec2, intrinsics: Intrinsics) -> Self {
        Self { size, intrinsics, distortion: Distortion::None }
    }

    /// The raw pixel where a point of the camera frame (metres, z forward) appears.
    ///
    /// `None` behind the camera (z ≤ 0), beyond the distortion's limit or for NaN;
    /// the pixel may lie outside the image, see [`Lens::contains`].
    pub fn project(&self, p_cam: DVec3) -> Option<DVec2> {
        if !(p_cam.z > 0.0) {
            return None;
        }
        self.distorted_from_normalised(p_cam.truncate() / p_cam.z)
    }

    /// The direction (x/z, y/z, 1) in the camera frame that a raw pixel sees, or `None`
    /// where the lens model reaches no such pixel.
    pub fn unproject(&self, pixel: DVec2) -> Option<DVec3> {
        let normalised = match self.distortion {
            Distortion::RadialPixels { .. } => {
                self.intrinsics.normalised_from_pixel(self.distortion.undistort(pixel)?)
            }
            _ => self.distortion.undistort(self.intrinsics.normalised_from_pixel(pixel))?,
        };
        Some(normalised.extend(1.0))
    }

    /// Raw pixel of the normalised pinhole position (x/z, y/z).
    pub fn distorted_from_normalised(&self, p: DVec2) -> Option<DVec2> {
        match self.distortion {
            Distortion::RadialPixels { .. } => {
                self.distortion.distort(self.intrinsics.pixel_from_normalised(p))
            }
            _ => Some(self.intrinsics.pixel_from_normalised(self.distortion.distort(p)?)),
        }
    }

    /// Whether a raw pixel lies in the image.
    pub fn contains(&self, pixel: DVec2) -> bool {
        let size = self.size.as_dvec2();
        pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x <= size.x && pixel.y <= size.y
    }

    /// The same lens for an image of another size (a level, or an image that is not of
    /// its calibration's size). Corners map to corners.
    pub fn scaled_to(&self, size: UVec2) -> Self {
        let s = size.as_dvec2() / self.size.as_dvec2();
        let i = self.intrinsics;
        let distortion = match self.distortion {
            Distortion::RadialPixels { centre, k, limit_px } => {
                // The model is radial in pixels, so only an isotropic scale keeps it exact;
                // levels differ from that by less than a pixel of rounding.
                let f = (s.x * s.y).sqrt();
                Distortion::RadialPixels {
                    centre: centre * s,
                    k: [k[0] / f.powi(2), k[1] / f.powi(4), k[2] / f.powi(6)],
                    limit_px: limit_px * f,
                }
            }
            other => other,
        };
        Self {
            size,
            intrinsics: Intrinsics {
                fx: i.fx * s.x,
                fy: i.fy * s.y,
                cx: i.cx * s.x,
                cy: i.cy * s.y,
            },
            distortion,
        }
    }
}

impl PosedCamera {
    /// Camera coordinates of a world point.
    pub fn cam_from_world(&self, p_world: DVec3) -> DVec3 {
        self.cam_from_world * (p_world - self.centre)
    }

    /// Raw pixel and depth (metres along the axis) of a world point; see [`Lens::project`].
    pub fn project(&self, p_world: DVec3) -> Option<(DVec2, f64)> {
        let p_cam = self.cam_from_world(p_world);
        Some((self.lens.project(p_cam)?, p_cam.z))
    }

    /// Direction of the optical axis in the world.
    pub fn forward(&self) -> DVec3 {
        self.cam_from_world.transpose() * DVec3::Z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world_from_rig;
    use proptest::prelude::*;

    /// A real, strongly distorted lens: off-centre, unequal focals.
    fn calibrated() -> Lens {
        Lens {
            size: UVec2::new(2048, 2048),
            intrinsics: Intrinsics { fx: 1150.7, fy: 1149.2, cx: 1030.29, cy: 1024.96 },
            distortion: Distortion::RadialPixels {
                centre: DVec2::new(1042.178, 1027.565),
                k: [
                    -1.337_915_876_037_518e-7,
                    3.475_409_773_283_144e-14,
                    -4.441_039_859_188_881e-21,
                ],
                limit_px: 2079.0,
            },
        }
    }

    proptest! {
        /// Pixels of a scaled lens are the pixels of the lens, scaled: every model, any size
        /// of the same proportions.
        #[test]
        fn scaled_lenses_scale_their_pixels(
            x in -0.7..0.7_f64, y in -0.7..0.7_f64, half in 1_u32..5000,
        ) {
            let models = [
                Distortion::None,
                calibrated().distortion,
                Distortion::Brown { k: [-0.2, 0.03, 0.0], p: [1e-3, -2e-3] },
                Distortion::Fisheye { k: [-0.02, 0.01, 0.0, 0.0] },
            ];
            for distortion in models {
                let lens = Lens { distortion, ..calibrated() };
                let scaled = lens.scaled_to(UVec2::splat(2 * half));
                let factor = f64::from(2 * half) / 2048.0;
                let point = DVec3::new(x, y, 1.0);
                let pixel = lens.project(point).expect("inside the limit");
                let found = scaled.project(point).expect("inside the limit");
                prop_assert!(found.distance(pixel * factor) < 1e-9 * factor.max(1.0), "{found} {pixel}");
                let back = scaled.unproject(found).expect("a pixel of the lens");
                prop_assert!(back.distance(point) < 1e-9, "{back} {point}");
            }
        }

        /// What a camera sees at a pixel lies on the ray that the pixel unprojects to,
        /// wherever the camera stands: at Lambert-93 northings f64 holds 1 nm.
        #[test]
        fn posed_cameras_see_what_they_unproject(
            heading in 0.0..6.3, pitch in -1.5..1.5, u in 0.0..2048.0, v in 0.0..2048.0,
            depth in 0.1..500.0_f64,
        ) {
            let cam_from_rig = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);
            let camera = PosedCamera {
                centre: DVec3::new(651_187.76, 6_861_379.05, 41.67),
                cam_from_world: cam_from_rig * world_from_rig(heading, pitch, 0.1).transpose(),
                lens: calibrated(),
            };
            let pixel = DVec2::new(u, v);
            let direction = camera.lens.unproject(pixel).expect("every pixel is in the model");
            let point = camera.centre + camera.cam_from_world.transpose() * (direction * depth);
            let (found, found_depth) = camera.project(point).expect("in front");
            // 1 nm at 0.1 m is 1e-8 of a tangent, times a focal length of 1150 px.
            prop_assert!(found.distance(pixel) < 1e-4, "{found} {pixel}");
            prop_assert!((found_depth - depth).abs() < 1e-8, "{found_depth} {depth}");
            prop_assert!((camera.forward().length() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn behind_and_on_the_eye_plane_is_seen_nowhere() {
        let lens = calibrated();
        for z in [0.0, -0.0, -1.0, f64::NAN] {
            assert_eq!(lens.project(DVec3::new(0.1, 0.1, z)), None, "{z}");
        }
        assert_eq!(lens.project(DVec3::new(f64::NAN, 0.1, 1.0)), None);
        // Grazing the eye plane: past every limit, not wrapped round.
        assert_eq!(lens.project(DVec3::new(1.0, 0.0, 1e-12)), None);
        assert_eq!(lens.project(DVec3::new(1.0, 0.0, f64::MIN_POSITIVE)), None);
    }

    #[test]
    fn images_hold_their_borders_and_no_more() {
        let lens = calibrated();
        for inside in [DVec2::ZERO, DVec2::splat(2048.0), DVec2::new(0.0, 2048.0)] {
            assert!(lens.contains(inside), "{inside}");
        }
        for outside in [DVec2::new(-1e-9, 5.0), DVec2::new(5.0, 2_048.000_001), DVec2::NAN] {
            assert!(!lens.contains(outside), "{outside}");
        }
    }

    #[test]
    fn the_field_of_view_reaches_the_top_and_the_bottom() {
        let size = UVec2::new(640, 360);
        let intrinsics = Intrinsics::from_fov_y(1.0, size);
        let lens = Lens::pinhole(size, intrinsics);
        let edge = lens.project(DVec3::new(0.0, 0.5_f64.tan(), 1.0)).expect("in front");
        assert!(edge.distance(DVec2::new(320.0, 360.0)) < 1e-10, "{edge}");
    }
}

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

//! The five-camera rig of the survey vehicle, as an iTowns calibration describes it.

use flaneur_scene::{Distortion, Intrinsics, Lens, PosedCamera, world_from_rig};
use glam::{DMat3, DVec2, DVec3, UVec2};
use serde_json::{Value, json};

use super::lens::Unprojector;
use super::picture::Sighting;
use super::{Station, rounded, vehicle};
use crate::frame::StreetFrame;
use crate::geometry::Ray;
use crate::look::Light;

/// The calibration is for images of this size, whatever size the images have.
const CALIBRATED_PX: u32 = 1024;
/// Height of the rig's origin above the published altitude, which is the road's.
pub(crate) const HEIGHT_OFFSET_M: f64 = 2.31;
/// The rig's mounting on the vehicle, about its x axis.
pub(crate) const BORESIGHT_DEG: f64 = 0.7;

/// The rig.
#[derive(Clone, Debug)]
pub(crate) struct Rig {
    /// Its cameras.
    pub(crate) cameras: Vec<Camera>,
}

/// One camera of the rig.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    /// Its number, which is its name.
    pub(crate) id: u32,
    /// Its lens at the calibration's size.
    pub(crate) lens: Lens,
    position_in_rig: DVec3,
    cam_from_rig: DMat3,
}

/// One exposure of the rig, with the very numbers that the pose file holds.
#[derive(Clone, Debug)]
pub(crate) struct RigPose {
    /// Number of the exposure.
    pub(crate) id: u32,
    /// Easting, northing, and altitude of the road below.
    pub(crate) position: DVec3,
    /// Clockwise from grid north.
    pub(crate) heading_deg: f64,
    /// Up.
    pub(crate) pitch_deg: f64,
    /// Right side down.
    pub(crate) roll_deg: f64,
    /// Seconds since the drive began.
    pub(crate) seconds: f64,
}

impl Rig {
    /// The rig of the survey: one camera looks up, four around; the front and back cameras
    /// hang upside down, and none is mounted quite straight.
    pub(crate) fn survey() -> Self {
        let around = |azimuth: f64| {
            let forward = DVec3::new(azimuth.sin(), azimuth.cos(), 0.0);
            [forward.cross(DVec3::Z), DVec3::NEG_Z, forward]
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let up = [DVec3::NEG_Y, DVec3::X, DVec3::Z];
        let [front, right, back, left] = [0.0, 1.0, 2.0, 3.0].map(|n| around(n * quarter));
        let flip = |[x, y, z]: [DVec3; 3]| [-x, -y, z];
        let mounts = [
            (600, up, DVec3::new(0.004, -0.012, 0.11), DVec3::new(0.2, -0.1, 0.15)),
            (601, flip(front), DVec3::new(0.012, 0.094, 0.006), DVec3::new(-0.25, 0.1, 0.3)),
            (602, right, DVec3::new(0.101, 0.003, 0.002), DVec3::new(0.1, 0.22, -0.2)),
            (603, flip(back), DVec3::new(-0.008, -0.108, 0.001), DVec3::new(0.15, -0.3, 0.1)),
            (604, left, DVec3::new(-0.097, -0.006, 0.004), DVec3::new(-0.12, -0.08, -0.28)),
        ];
        let cameras = mounts.into_iter().zip(0..).map(|((id, axes, position, lean_deg), n)| {
            let n = f64::from(n);
            let lean = lean_deg.map(f64::to_radians);
            let misaligned = DMat3::from_rotation_x(lean.x)
                * DMat3::from_rotation_y(lean.y)
                * DMat3::from_rotation_z(lean.z);
            let straight = DMat3::from_cols(axes[0], axes[1], axes[2]).transpose();
            let focal = 548.0 + 3.1 * n;
            Camera {
                id,
                lens: Lens {
                    size: UVec2::splat(CALIBRATED_PX),
                    intrinsics: Intrinsics {
                        fx: focal,
                        fy: focal,
                        cx: 515.3 - 1.7 * n,
                        cy: 509.2 + 1.1 * n,
                    },
                    distortion: Distortion::RadialPixels {
                        centre: DVec2::new(517.4, 514.9),
                        k: [(-3.05 - 0.06 * n) * 1e-7, 2.1e-13, -5.5e-20],
                        limit_px: 960.0 + n,
                    },
                },
                position_in_rig: position,
                cam_from_rig: misaligned * straight,
            }
        });
        Self { cameras: cameras.collect() }
    }

    /// The calibration as iTowns writes it. `masked` says which cameras have a mask.
    pub(crate) fn calibration(&self, masked: impl Fn(u32) -> Option<String>) -> Value {
        let cameras = self.cameras.iter().map(|camera| {
            let i = camera.lens.intrinsics;
            let Distortion::RadialPixels { centre, k, limit_px } = camera.lens.distortion else {
                unreachable!("the rig's lenses are radial in pixels")
            };
            let mut entry = json!({
                "id": camera.id,
                // Rows.
                "rotation": camera.cam_from_rig.transpose().to_cols_array(),
                "position": camera.position_in_rig.to_array(),
                "projection": [i.fx, 0.0, i.cx, 0.0, i.fy, i.cy, 0.0, 0.0, 1.0],
                "size": camera.lens.size.to_array(),
                "distortion": { "pps": centre.to_array(), "poly357": k, "limit": limit_px },
            });
            if let Some(mask) = masked(camera.id) {
                entry["mask"] = Value::from(mask);
            }
            entry
        });
        Value::Array(cameras.collect())
    }
}

impl Camera {
    /// The camera in the world, for images of `size`.
    pub(crate) fn posed(&self, pose: &RigPose, size: UVec2) -> PosedCamera {
        let world_from_rig = pose.world_from_rig();
        PosedCamera {
            centre: pose.origin() + world_from_rig * self.position_in_rig,
            cam_from_world: self.cam_from_rig * world_from_rig.transpose(),
            lens: self.lens.scaled_to(size),
        }
    }

    /// The lines of sight of this camera at a pose.
    pub(crate) fn sight<'a>(
        &'a self,
        pose: &RigPose,
        size: UVec2,
        light: &'a Light,
    ) -> impl Fn(DVec2) -> Option<Sighting> + Sync + 'a {
        let camera = self.posed(pose, size);
        let inverse = Unprojector::new(camera.lens);
        let station = Station::new(camera.centre, camera.cam_from_world.transpose());
        let street_from_rig =
            StreetFrame::PLACE.world_from_street().transpose() * pose.world_from_rig();
        move |pixel| {
            let direction = inverse.direction(pixel)?;
            let ray = station.ray(direction);
            let vehicle =
                vehicle::vehicle(&self.ray_in_rig(direction), light, ray.origin, street_from_rig);
            Some(Sighting { ray, depth_per_metre: 1.0 / direction.length(), vehicle })
        }
    }

    /// The mask of this camera at the calibration's size: white where the vehicle is, or
    /// within two pixels of it; `None` where it is nowhere.
    pub(crate) fn mask(&self) -> Option<Vec<u8>> {
        let side = CALIBRATED_PX as usize;
        let inverse = Unprojector::new(self.lens);
        let hidden: Vec<bool> = (0..side * side)
            .map(|i| {
                let pixel = DVec2::new((i % side) as f64, (i / side) as f64) + 0.5;
                inverse.direction(pixel).is_none_or(|d| vehicle::hides(&self.ray_in_rig(d)))
            })
            .collect();
        let near = |i: usize| {
            let (column, row) = (i % side, i / side);
            let span = |at: usize| at.saturating_sub(2)..(at + 3).min(side);
            span(row).any(|r| span(column).any(|c| hidden[r * side + c]))
        };
        hidden
            .contains(&true)
            .then(|| (0..side * side).map(|i| if near(i) { 255 } else { 0 }).collect())
    }

    /// Size of the mask.
    pub(crate) fn mask_size(&self) -> UVec2 {
        self.lens.size
    }

    fn ray_in_rig(&self, direction_cam: DVec3) -> Ray {
        let direction = (self.cam_from_rig.transpose() * direction_cam).normalize();
        Ray { origin: self.position_in_rig, direction }
    }
}

impl RigPose {
    /// The pose with its numbers rounded as the file holds them.
    pub(crate) fn rounded(self) -> Self {
        Self {
            position: self.position.map(|x| rounded(x, 3)),
            heading_deg: rounded(self.heading_deg, 6),
            pitch_deg: rounded(self.pitch_deg, 6),
            roll_deg: rounded(self.roll_deg, 6),
            ..self
        }
    }

    /// World position of the rig's origin.
    pub(crate) fn origin(&self) -> DVec3 {
        self.position + DVec3::Z * HEIGHT_OFFSET_M
    }

    /// Rotation of the rig, boresight included.
    pub(crate) fn world_from_rig(&self) -> DMat3 {
        let [h, p, r] = [self.heading_deg, self.pitch_deg, self.roll_deg].map(f64::to_radians);
        world_from_rig(h, p, r) * DMat3::from_rotation_x(BORESIGHT_DEG.to_radians())
    }

    /// The entry of the pose file.
    pub(crate) fn entry(&self) -> Value {
        json!({
            "id": self.id,
            "easting": self.position.x,
            "northing": self.position.y,
            "altitude": self.position.z,
            "heading": self.heading_deg,
            "roll": self.roll_deg,
            "pitch": self.pitch_deg,
            "date": time_of_day(self.seconds),
        })
    }
}

/// RFC 3339 time of the drive, which takes less than an hour.
pub(crate) fn time_of_day(seconds: f64) -> String {
    let (minutes, rest) = ((seconds / 60.0).floor(), seconds.rem_euclid(60.0));
    let (hours, minutes) = (10.0 + (minutes / 60.0).floor(), minutes.rem_euclid(60.0));
    format!("2024-05-14T{hours:02.0}:{minutes:02.0}:{rest:06.3}Z")
}

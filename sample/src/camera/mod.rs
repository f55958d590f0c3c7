//! Cameras of the survey, and the pictures that they take.

mod lens;
mod pedestrian;
mod picture;
mod rig;
mod sphere;
mod survey;
mod vehicle;
mod viewpoint;

pub(crate) use pedestrian::there_and_back;
pub(crate) use picture::{Picture, take};
pub(crate) use rig::{BORESIGHT_DEG, HEIGHT_OFFSET_M, Rig, RigPose};
pub(crate) use sphere::SpherePose;
pub(crate) use survey::Survey;
pub(crate) use viewpoint::{Viewpoint, choose_viewpoints};

use glam::{DMat3, DVec3};

use crate::frame::StreetFrame;
use crate::geometry::Ray;

/// Where a camera is in the street frame, and how its directions turn into it: a line of
/// sight is wanted for every pixel, so what does not depend on the pixel is kept.
#[derive(Clone, Copy, Debug)]
struct Station {
    origin: DVec3,
    street_from_cam: DMat3,
}

impl Station {
    /// The station of a camera at a world position.
    fn new(centre_world: DVec3, world_from_cam: DMat3) -> Self {
        let frame = StreetFrame::PLACE;
        Self {
            origin: frame.point_from_world(centre_world),
            street_from_cam: frame.world_from_street().transpose() * world_from_cam,
        }
    }

    /// The line of sight along a direction of the camera frame, of any length.
    fn ray(&self, direction_cam: DVec3) -> Ray {
        Ray { origin: self.origin, direction: (self.street_from_cam * direction_cam).normalize() }
    }
}

/// Rounds to the decimals that a file will hold, so that what is traced is what is written.
pub(crate) fn rounded(value: f64, decimals: i32) -> f64 {
    let unit = 10f64.powi(decimals);
    (value * unit).round() / unit
}

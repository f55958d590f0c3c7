//! Cameras of the survey, and the pictures that they take.

mod lens;
mod picture;
mod rig;
mod sphere;
mod survey;
mod vehicle;
mod viewpoint;

pub(crate) use picture::{Picture, take};
pub(crate) use rig::{BORESIGHT_DEG, HEIGHT_OFFSET_M, Rig, RigPose};
pub(crate) use sphere::SpherePose;
pub(crate) use survey::Survey;
pub(crate) use viewpoint::{Viewpoint, choose_viewpoints};

use glam::DVec3;

use crate::frame::StreetFrame;
use crate::geometry::Ray;

/// The ray in the street frame from a world position along a world direction.
fn street_ray(centre_world: DVec3, direction_world: DVec3) -> Ray {
    let frame = StreetFrame::PLACE;
    Ray {
        origin: frame.point_from_world(centre_world),
        direction: (frame.world_from_street().transpose() * direction_world).normalize(),
    }
}

/// Rounds to the decimals that a file will hold, so that what is traced is what is written.
pub(crate) fn rounded(value: f64, decimals: i32) -> f64 {
    let unit = 10f64.powi(decimals);
    (value * unit).round() / unit
}

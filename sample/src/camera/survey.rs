//! Where the photographs are taken: a drive down the right lane, a walk on the left.

use glam::DVec3;
use rand::RngExt;

use super::rig::BORESIGHT_DEG;
use super::{Rig, RigPose, SpherePose};
use crate::frame::StreetFrame;
use crate::street::{Purpose, Street, random};

/// Speed of the vehicle and of the walker, metres a second.
const DRIVE_M_S: f64 = 4.2;
const WALK_M_S: f64 = 1.2;
const FIRST_EXPOSURE: u32 = 101;

/// Every exposure of the survey.
#[derive(Clone, Debug)]
pub(crate) struct Survey {
    /// The rig of the drive.
    pub(crate) rig: Rig,
    /// Its exposures, in order.
    pub(crate) drive: Vec<RigPose>,
    /// The spheres of the walk, in order.
    pub(crate) walk: Vec<SpherePose>,
}

impl Survey {
    /// The survey of a street with so many exposures.
    pub(crate) fn new(street: &Street, seed: u64, exposures: u32, spheres: u32) -> Self {
        let mut rng = random(seed, Purpose::Survey, 0);
        let mut wobble = |size: f64| rng.random_range(-size..size);
        let frame = StreetFrame::PLACE;
        let heading = frame.heading().to_degrees();
        let (start, end) = (-1.0, street.length_m - 6.0);
        let drive = (0..exposures)
            .map(|i| {
                let t = (f64::from(i) + 0.5) / f64::from(exposures);
                let x = start + t * (end - start);
                let position =
                    DVec3::new(x, -1.35 + 0.25 * (x / 17.0).sin(), street.terrain.axis(x));
                let slope = (street.terrain.axis(x + 1.5) - street.terrain.axis(x - 1.5)) / 3.0;
                RigPose {
                    id: FIRST_EXPOSURE + i,
                    position: frame.world_from_point(position),
                    heading_deg: heading + 0.8 * (x / 9.0).sin() + wobble(0.4),
                    // The boresight lifts the rig; the road tilts it.
                    pitch_deg: slope.atan().to_degrees() - BORESIGHT_DEG + wobble(0.5),
                    roll_deg: wobble(0.8),
                    seconds: x.max(0.0) / DRIVE_M_S,
                }
                .rounded()
            })
            .collect();
        let walk = (0..spheres)
            .map(|i| {
                let t = (f64::from(i) + 0.5) / f64::from(spheres);
                let x = 2.0 + t * (street.length_m - 4.0);
                let y = 6.55 + wobble(0.12);
                let position = DVec3::new(x, y, street.terrain.height(x, y) + 1.93);
                SpherePose {
                    id: format!("walk-{:03}", i + 1),
                    position: frame.world_from_point(position),
                    heading_deg: heading + wobble(25.0),
                    pitch_deg: wobble(3.0),
                    roll_deg: wobble(3.0),
                    seconds: 600.0 + x / WALK_M_S,
                }
                .rounded()
            })
            .collect();
        Self { rig: Rig::survey(), drive, walk }
    }

    /// World positions of the centres of all photographs.
    pub(crate) fn centres(&self) -> Vec<DVec3> {
        let of_rig = self.drive.iter().flat_map(|pose| {
            self.rig.cameras.iter().map(|camera| camera.posed(pose, camera.lens.size).centre)
        });
        of_rig.chain(self.walk.iter().map(|pose| pose.position)).collect()
    }
}

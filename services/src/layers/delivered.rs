//! `panoramas.{version}.delivered.json`: how poses that were corrected were delivered.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// How a pose that was corrected was delivered, and what the correction is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeliveredPose {
    /// The panorama.
    pub panorama: String,
    /// Place of its rig, world frame, metres.
    pub position: DVec3,
    /// Its attitude, row by row.
    pub world_from_rig: [[f64; 3]; 3],
    /// The corrected attitude is `exp([turn_rad]×) world_from_rig`: an axis of the world times
    /// the angle, radians.
    pub turn_rad: DVec3,
    /// The corrected place is `position + shift_m`, metres.
    pub shift_m: DVec3,
}

impl DeliveredPose {
    /// What is stored of a pose.
    pub fn new(
        panorama: String,
        position: DVec3,
        world_from_rig: DMat3,
        turn_rad: DVec3,
        shift_m: DVec3,
    ) -> Self {
        let world_from_rig = world_from_rig.transpose().to_cols_array_2d();
        Self { panorama, position, world_from_rig, turn_rad, shift_m }
    }
}

/// The file's content.
///
/// # Errors
///
/// Where memory runs out.
pub fn encode(poses: &[DeliveredPose]) -> Result<Vec<u8>, serde_json::Error> {
    serde_json::to_vec_pretty(poses)
}

/// What [`encode`] wrote.
///
/// # Errors
///
/// Where the bytes are no such file.
pub fn decode(bytes: &[u8]) -> Result<Vec<DeliveredPose>, serde_json::Error> {
    serde_json::from_slice(bytes)
}

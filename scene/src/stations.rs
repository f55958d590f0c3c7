//! Where the vehicle of a survey was when it took its points.
//!
//! Poses drift: a place that a survey passes twice, or sees from two ends of a street, lies where
//! each moment has it, decimetres apart. What was taken at one moment agrees with itself.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Where a survey was at some time, as far as its points tell: the mean of those taken about then.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Station {
    /// The survey's GPS time, seconds.
    pub time_s: f64,
    /// World frame, metres.
    pub position: DVec3,
    /// How the points of then are shown, where the survey had its vehicle slightly elsewhere.
    #[serde(default, skip_serializing_if = "StationCorrection::is_none")]
    pub correction: StationCorrection,
}

/// A small rigid motion about a station's position, from where a survey has its points to where
/// they belong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StationCorrection {
    /// Turn about the station's position: axis of the world times angle, radians.
    pub turn_rad: DVec3,
    /// Then this is added, metres.
    pub shift_m: DVec3,
}

impl StationCorrection {
    /// Whether nothing moves.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// The turn as a matrix.
    pub fn turn(&self) -> DMat3 {
        DMat3::from_quat(DQuat::from_scaled_axis(self.turn_rad))
    }
}

/// Where the points of a chunk were taken from, as far as that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct PointStations {
    /// All places from which the chunk's source was taken, world frame, metres; shared by its
    /// chunks.
    pub places: Arc<[DVec3]>,
    /// Of each point its index in `places`, [`PointStations::UNKNOWN`] where it has none; empty
    /// where none has.
    pub of_points: Vec<u16>,
}

impl PointStations {
    /// The index of points of which it is not known.
    pub const UNKNOWN: u16 = u16::MAX;

    /// Whence the point with the index `point` was taken; `None` where that is not known.
    pub fn of_point(&self, point: usize) -> Option<DVec3> {
        self.places.get(usize::from(*self.of_points.get(point)?)).copied()
    }
}

impl Default for PointStations {
    /// Nothing is known.
    fn default() -> Self {
        Self { places: Arc::new([]), of_points: Vec::new() }
    }
}

//! How far photographs show tracks from where poses let them be, and what that costs.

use glam::{DMat3, DVec2, DVec3};

use super::track::Track;
use super::{Adjustment, Correction};

/// Places closer than this to a camera's plane, as a share of their distance, are not seen by it.
pub(super) const LEAST_DEPTH: f64 = 1e-3;

impl Adjustment {
    /// Centre, camera from world axes, and lever of a camera as corrected.
    pub(super) fn pose(&self, camera: usize) -> (DVec3, DMat3, DVec3) {
        let camera = &self.cameras[camera];
        let Correction { turn, shift } = self.corrections[camera.panorama];
        let lever = turn * camera.lever;
        let centre = self.places[camera.panorama] + shift + lever;
        (centre, camera.cam_from_world * turn.transpose(), lever)
    }

    /// Pixels from where a photograph has a track to where it should; `None` behind it.
    pub(super) fn error(&self, track: &Track, (camera, seen): (usize, DVec2)) -> Option<DVec2> {
        let (centre, rotation, _) = self.pose(camera);
        let shown = rotation * (track.direction - track.inverse * (centre - track.anchor));
        (shown.z > LEAST_DEPTH)
            .then(|| self.cameras[camera].focal_px * (shown.truncate() / shown.z - seen))
    }

    pub(super) fn cost_of(&self, track: &Track, soft_px: f64) -> f64 {
        let square = soft_px * soft_px;
        let most = square * 1e6f64.ln();
        let cost = |sighting: &(usize, DVec2)| {
            self.error(track, *sighting).map_or(most, |error| {
                (square * (error.length_squared() / square).ln_1p()).min(most)
            })
        };
        track.sightings.iter().map(cost).sum()
    }

    pub(super) fn cost(&self, soft_px: f64) -> f64 {
        let corrections = self.corrections.iter().zip(&self.priors).map(|(correction, prior)| {
            correction.shift.length_squared() / (prior.shift_m * prior.shift_m)
                + correction.turn_rad().length_squared() / (prior.turn_rad * prior.turn_rad)
        });
        let tracks = self.tracks.iter().map(|track| self.cost_of(track, soft_px));
        corrections.sum::<f64>() + tracks.sum::<f64>()
    }
}

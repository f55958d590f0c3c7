//! A place that several photographs show, and where it is looked for first.

use glam::{DVec2, DVec3};

use super::{Adjustment, SOFT_PX};

/// A place and what shows it.
#[derive(Clone, Debug)]
pub(in super::super) struct Track {
    /// The centre `a`, metres.
    pub(super) anchor: DVec3,
    /// The unit direction `d`.
    pub(super) direction: DVec3,
    /// ρ, 1/m, zero or more.
    pub(super) inverse: f64,
    /// Index of a camera, and where it has the place: (x/z, y/z).
    pub(super) sightings: Vec<(usize, DVec2)>,
}

/// Inverse distances at which a track is first looked for, in a row where each is so many times the
/// one before.
const NEAREST_M: f64 = 0.5;
const FARTHEST_M: f64 = 300.0;
const RATIO: f64 = 1.25;

impl Adjustment {
    /// Where a track is, if all poses are right: the distance that fits best among many.
    pub(super) fn first_guess(&self, sightings: Vec<(usize, DVec2)>) -> Option<Track> {
        let (first, seen) = *sightings.first()?;
        let (anchor, cam_from_world, _) = self.pose(first);
        let direction = (cam_from_world.transpose() * seen.extend(1.0)).normalize();
        let mut track = Track { anchor, direction, inverse: 0.0, sightings };
        let mut best = (f64::INFINITY, 0.0);
        let count = ((FARTHEST_M / NEAREST_M).ln() / RATIO.ln()).ceil() as i32;
        let inverses = (0..=count).map(|k| RATIO.powi(k) / FARTHEST_M);
        for inverse in std::iter::once(0.0).chain(inverses) {
            track.inverse = inverse;
            let cost = self.cost_of(&track, SOFT_PX[0]);
            if cost < best.0 {
                best = (cost, inverse);
            }
        }
        track.inverse = best.1;
        best.0.is_finite().then_some(track)
    }
}

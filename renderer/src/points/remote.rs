//! Which points go before others: those taken near the eye.
//!
//! The poses of a survey drift, by centimetres a metre. What the vehicle measured beside the eye
//! agrees with the photographs taken there; what it measured of the same places from elsewhere
//! lies decimetres off. And where it looked past a place from beside the eye, nothing stands there.
//!
//! How remote a block of points is, `u = (s − s₀) min(1, 3 m / s₀)`, is by how much farther its
//! station is (s) than the nearest place that its source was taken from (s₀); far from all of them
//! that makes less and less of a difference. Without times every block is at 0.
//!
//! - In a view blocks are put 20 m behind for each metre of u beyond the first, at most 100 m: in
//!   the order of points alone, so that what is shown stays where it is. It is continuous in the
//!   eye, and where no near point is seen the others still close the gap.
//! - In a photograph's depth map every metre of u is a rank, and nearer ranks go first. As the map
//!   keeps no more than a number a texel, that is `16384 m · rank + depth`. A block that is farther
//!   away than u is left out: from so near the vehicle has measured the place itself, or has seen
//!   that it is not there. A scanner that only measures abreast loses nothing by that.

use flaneur_scene::Bounds3;
use glam::DVec3;

use super::Chunk;

/// Metres between the ranks of a depth map, and the farthest that it knows of a point. Mirrored in
/// depth_map/point.wgsl.
const RANK_M: f64 = 16_384.0;
/// Ranks of a depth map.
const RANKS: f64 = 16.0;
/// Remoteness of which a view takes no notice, metres.
const NEAR_M: f64 = 1.0;
/// Metres that a block is put behind in a view, for each of its remoteness.
const BEHIND: f64 = 20.0;
const MOST_BEHIND_M: f64 = 100.0;
/// Farther from all stations than this the eye makes less of their differences, metres.
const BESIDE_M: f64 = 3.0;
/// Blocks nearer than this are not nearer still, metres.
const NEAREST_M: f64 = 3.0;

/// What goes before what, as one camera has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Precedence {
    /// All points are alike.
    None,
    /// As in a view.
    View,
    /// As in a depth map.
    Map,
}

/// How remote blocks are for one camera.
#[derive(Debug)]
pub(super) struct Remoteness {
    precedence: Precedence,
    centre: DVec3,
    /// The places that were looked at last, and the distance of the nearest of them: chunks of a
    /// source share theirs.
    nearest: Option<(*const DVec3, f64)>,
}

impl Remoteness {
    pub(super) fn new(precedence: Precedence, centre: DVec3) -> Self {
        Self { precedence, centre, nearest: None }
    }

    /// Metres that a block of `chunk` is put behind, with its station and its box; `None` where it
    /// is left out.
    pub(super) fn behind(
        &mut self,
        chunk: &Chunk,
        station: Option<DVec3>,
        bounds: &Bounds3,
    ) -> Option<f32> {
        let Some(station) = station.filter(|_| self.precedence != Precedence::None) else {
            return Some(0.0);
        };
        let u = remoteness(station.distance(self.centre), self.nearest(&chunk.places));
        match self.precedence {
            Precedence::Map => {
                let away = bounds.centre().distance(self.centre).max(NEAREST_M);
                (u <= away).then(|| (rank(u) * RANK_M) as f32)
            }
            _ => Some(behind_in_view(u) as f32),
        }
    }

    fn nearest(&mut self, places: &[DVec3]) -> f64 {
        if let Some((of, nearest_m)) = self.nearest
            && of == places.as_ptr()
        {
            return nearest_m;
        }
        let away = places.iter().map(|place| place.distance_squared(self.centre));
        let nearest_m = away.fold(f64::INFINITY, f64::min).sqrt();
        self.nearest = Some((places.as_ptr(), nearest_m));
        nearest_m
    }
}

fn remoteness(station_m: f64, nearest_m: f64) -> f64 {
    (station_m - nearest_m).max(0.0) * (BESIDE_M / nearest_m).min(1.0)
}

fn behind_in_view(u: f64) -> f64 {
    (BEHIND * (u - NEAR_M)).clamp(0.0, MOST_BEHIND_M)
}

fn rank(u: f64) -> f64 {
    u.floor().min(RANKS - 1.0)
}

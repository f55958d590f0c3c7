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
//! - In a view blocks are put 0.3 m behind for each metre of u beyond the first, at most 10 m: in
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
/// Metres that a block is put behind in a view, for each of its remoteness: several times what poses
/// drift, and little enough that what the vehicle saw beyond a car from above its roof does not
/// go before the roof.
const BEHIND: f64 = 0.3;
const MOST_BEHIND_M: f64 = 10.0;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Along a walk past the stations and away from them, everything in small steps.
    #[test]
    fn what_is_behind_is_continuous_in_the_eye() {
        let places: Vec<DVec3> = (0..40).map(|i| DVec3::new(0.0, f64::from(i), 2.0)).collect();
        let behind = |station: usize, eye: DVec3| {
            let away = places.iter().map(|place| place.distance(eye));
            let nearest = away.fold(f64::INFINITY, f64::min);
            behind_in_view(remoteness(places[station].distance(eye), nearest))
        };
        let step_m = 0.01;
        for station in [0, 17, 39] {
            let walk = |i: u32| {
                let way = f64::from(i) * step_m;
                DVec3::new((0.1 * way).sin() * 9.0, 0.5 * way - 5.0, 1.7)
            };
            let (mut least, mut most) = (f64::INFINITY, 0.0f64);
            for i in 0..10_000 {
                let [here, next] = [walk(i), walk(i + 1)];
                let change = (behind(station, next) - behind(station, here)).abs();
                // u follows either distance as it is, and how much of their difference counts
                // by u / s₀ at most.
                let most_remote = NEAR_M + MOST_BEHIND_M / BEHIND;
                let steepest = BEHIND * (2.0 + most_remote / BESIDE_M);
                assert!(change <= steepest * here.distance(next), "{here}: {change}");
                least = least.min(behind(station, here));
                most = most.max(behind(station, here));
            }
            assert!(least == 0.0 && most > 0.5 * MOST_BEHIND_M, "{station}: {least} {most}");
        }
    }

    #[test]
    fn the_nearest_place_is_not_remote_and_far_from_all_they_are_alike() {
        assert_eq!(remoteness(2.0, 2.0), 0.0);
        assert_eq!(remoteness(12.0, 2.0), 10.0);
        // A mean of places can be nearer than any of them.
        assert_eq!(remoteness(1.0, 2.0), 0.0);
        assert!((remoteness(320.0, 300.0) - 0.2).abs() < 1e-12);
        assert_eq!((rank(0.99), rank(1.0), rank(1e9)), (0.0, 1.0, 15.0));
    }

    /// Every rank keeps depths to centimetres, and tells them from the next.
    #[test]
    fn ranks_hold_depths() {
        for rank in 0..RANKS as u32 {
            for depth in [0.1f32, 7.123, 250.0, 9000.0] {
                let held = (f64::from(rank) * RANK_M) as f32 + depth;
                let shift = RANK_M as f32 * (held / RANK_M as f32).floor();
                assert!((held - shift - depth).abs() < 0.01, "{rank} {depth}");
            }
        }
    }
}

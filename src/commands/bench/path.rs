//! A path along which the view moves.

use flaneur_scene::View;
use glam::{DVec3, UVec2};

use crate::names::Names;

/// Frames along it.
const STEPS: usize = 36;
/// Between them, metres: someone who walks, some five frames a second.
const STEP_M: f64 = 0.3;
/// How far ahead the view looks, metres: corners are rounded by as much.
const AHEAD_M: f64 = 4.0;
/// Panoramas farther apart than this do not follow each other, metres.
const APART_M: f64 = 30.0;
/// What the view turns between frames where the way has come to its end, degrees.
const TURN_DEG: f64 = 2.0;

/// Views along the way of the survey, from near `start` on, each ahead; where the way ends it turns
/// on the spot. None in a scene without photographs.
pub(super) fn along_survey(names: &Names, start: DVec3, fov_deg: f64, size: UVec2) -> Vec<View> {
    let mut stations: Vec<DVec3> =
        names.photographs().values().map(|photograph| photograph.panorama.position).collect();
    stations.dedup();
    let away =
        |way: &[DVec3]| way.iter().map(|at| at.distance(start)).fold(f64::INFINITY, f64::min);
    // Drives that only their names join are ways of their own.
    let ways = stations.chunk_by(|a, b| a.distance(*b) < APART_M);
    let nearest = ways.min_by(|a, b| away(a).total_cmp(&away(b)));
    nearest.map_or_else(Vec::new, |way| {
        Way::new(way, start)
            .views()
            .map(|(eye, heading)| View::look(eye, heading, 0.0, fov_deg.to_radians(), size))
            .collect()
    })
}

/// A polyline.
struct Way {
    stations: Vec<DVec3>,
    /// From the first station to each, metres.
    metres: Vec<f64>,
    /// Where the path begins, metres.
    begin_m: f64,
}

impl Way {
    /// That of `stations`, of which there must be one; a path on it begins near `start`, or so
    /// much earlier that it has room.
    fn new(stations: &[DVec3], start: DVec3) -> Self {
        let mut metres = vec![0.0];
        for pair in stations.windows(2) {
            metres.push(metres.last().unwrap_or(&0.0) + pair[0].distance(pair[1]));
        }
        let length_m = metres.last().copied().unwrap_or(0.0);
        let distances = stations.iter().zip(&metres).map(|(at, m)| (at.distance(start), *m));
        let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, m)| m);
        let begin_m = nearest.min(length_m - STEPS as f64 * STEP_M).max(0.0);
        Self { stations: stations.to_vec(), metres, begin_m }
    }

    fn at(&self, m: f64) -> DVec3 {
        let after = self.metres.partition_point(|&metres| metres <= m);
        let (Some(&b), Some(&b_m)) = (self.stations.get(after), self.metres.get(after)) else {
            return self.stations.last().copied().unwrap_or_default();
        };
        let (a, a_m) = (self.stations[after.max(1) - 1], self.metres[after.max(1) - 1]);
        a.lerp(b, (m - a_m) / (b_m - a_m))
    }

    /// Eyes, and headings clockwise from north, radians.
    fn views(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let end_m = self.metres.last().copied().unwrap_or(0.0);
        let mut heading = 0.0;
        (0..STEPS).map(move |step| {
            let m = self.begin_m + step as f64 * STEP_M;
            let ahead = (self.at(m + AHEAD_M) - self.at(m - AHEAD_M)).truncate();
            if m >= end_m {
                heading += TURN_DEG.to_radians();
            } else if ahead.length() > 0.1 {
                heading = ahead.x.atan2(ahead.y);
            }
            (self.at(m), heading)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_follows_its_stations() {
        let stations: Vec<DVec3> =
            (0..40).map(|i| DVec3::new(100.0 + 2.0 * f64::from(i), 50.0, 3.0)).collect();
        let way = Way::new(&stations, DVec3::new(120.5, 48.0, 3.0));
        let views: Vec<_> = way.views().collect();
        assert_eq!(views[0].0, DVec3::new(120.0, 50.0, 3.0));
        for (step, (eye, heading)) in views.iter().enumerate() {
            assert!((eye.x - 120.0 - 0.3 * step as f64).abs() < 1e-9, "{eye}");
            assert!((heading.to_degrees() - 90.0).abs() < 1e-9, "east");
        }
        let late = Way::new(&stations, DVec3::new(1e4, 0.0, 0.0));
        assert!(late.views().all(|(eye, _)| eye.x < 178.0), "it begins so early that it has room");
    }

    #[test]
    fn where_there_is_no_way_the_view_turns() {
        let way = Way::new(&[DVec3::ZERO], DVec3::X);
        let views: Vec<_> = way.views().collect();
        assert!(views.iter().all(|(eye, _)| *eye == DVec3::ZERO));
        assert!((views[35].1 - views[0].1).to_degrees() > 60.0);
    }
}

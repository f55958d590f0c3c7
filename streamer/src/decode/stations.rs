//! Where the vehicle of a survey was at the time of each point.

use std::sync::Arc;

use flaneur_scene::{PointStations, Station};
use glam::{DMat3, DVec3};

/// Places of one survey lie about this far apart, metres.
const APART_M: f64 = 1.5;
/// Between stations farther apart in time than so many times the usual there is a break, not a
/// way.
const BREAK: f64 = 4.0;
/// Most places: fewer than [`PointStations::UNKNOWN`].
const MOST_PLACES: usize = 1 << 15;
/// Points that should come from one run of places, so that whole runs of points can be told
/// apart: those that a renderer draws together.
const RUN_POINTS: usize = 256;

/// Places from which a source was taken, in the order of time.
#[derive(Debug)]
pub(crate) struct Track {
    times_s: Vec<f64>,
    places: Arc<[DVec3]>,
    /// How points are shown, by the time at which they were taken; empty where all are as they are.
    motions: Vec<Motion>,
}

/// A station's correction.
#[derive(Clone, Copy, Debug)]
struct Motion {
    time_s: f64,
    pivot: DVec3,
    turn: DMat3,
    turn_rad: f64,
    shift: DVec3,
}

/// Points farther than this from where they were taken are few, metres.
const FAR_M: f64 = 150.0;

impl Track {
    /// The track through `stations`, which ascend in time: where they are far apart it has places
    /// between them, and where they are near it passes some over.
    pub(crate) fn through(stations: &[Station]) -> Self {
        let mut steps: Vec<f64> =
            stations.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
        steps.sort_unstable_by(f64::total_cmp);
        let longest_s = steps.get(steps.len() / 2).map_or(0.0, |usual| BREAK * usual);
        let mut apart_m = APART_M;
        loop {
            let track = with_places(stations, apart_m, longest_s);
            if track.len() <= MOST_PLACES {
                let (times_s, places): (Vec<f64>, Vec<DVec3>) = track.into_iter().unzip();
                let motions = motions(stations);
                let track = Self { times_s, places: places.into(), motions };
                let shown = |(time_s, place): (&f64, &DVec3)| track.shown(*time_s, *place);
                let places = track.times_s.iter().zip(track.places.iter()).map(shown).collect();
                return Self { places, ..track };
            }
            apart_m *= 2.0;
        }
    }

    /// Where a point that the survey has at `place` is shown, world.
    pub(crate) fn shown(&self, time_s: f64, place: DVec3) -> DVec3 {
        if self.motions.is_empty() || !time_s.is_finite() {
            return place;
        }
        let after = self.motions.partition_point(|motion| motion.time_s < time_s);
        let before = after.checked_sub(1).and_then(|before| self.motions.get(before));
        match (before, self.motions.get(after)) {
            (Some(before), Some(after)) => {
                let share = (time_s - before.time_s) / (after.time_s - before.time_s);
                before.of(place).lerp(after.of(place), share.clamp(0.0, 1.0))
            }
            (Some(only), None) | (None, Some(only)) => only.of(place),
            (None, None) => place,
        }
    }

    /// How far from where the survey has them points about `place` are shown, metres, at most.
    pub(crate) fn farthest_m(&self, place: DVec3) -> f64 {
        let near = |motion: &&Motion| motion.pivot.distance(place) <= FAR_M;
        let farthest = |motion: &Motion| {
            motion.shift.length() + motion.turn_rad * motion.pivot.distance(place)
        };
        self.motions.iter().filter(near).map(farthest).fold(0.0, f64::max)
    }

    /// Which places the points were taken from, by their times; nothing where the track is a
    /// single place, or none.
    pub(super) fn stations_of(&self, times_s: &[f64]) -> PointStations {
        if self.places.len() < 2 {
            return PointStations::default();
        }
        let of_points = times_s.iter().map(|&time_s| self.index(time_s)).collect();
        PointStations { places: Arc::clone(&self.places), of_points }
    }

    /// The place that is nearest in time.
    fn index(&self, time_s: f64) -> u16 {
        if !time_s.is_finite() {
            return PointStations::UNKNOWN;
        }
        let after = self.times_s.partition_point(|&t| t < time_s);
        let gap = |index: usize| self.times_s.get(index).map(|t| (t - time_s).abs());
        let nearest = match (after.checked_sub(1).and_then(gap), gap(after)) {
            (Some(before), Some(next)) if next < before => after,
            (None, _) => after,
            (Some(_), _) => after - 1,
        };
        u16::try_from(nearest).unwrap_or(PointStations::UNKNOWN)
    }
}

impl Motion {
    fn of(&self, place: DVec3) -> DVec3 {
        self.turn * (place - self.pivot) + self.pivot + self.shift
    }
}

fn motions(stations: &[Station]) -> Vec<Motion> {
    if stations.iter().all(|station| station.correction.is_none()) {
        return Vec::new();
    }
    let motion = |station: &Station| Motion {
        time_s: station.time_s,
        pivot: station.position,
        turn: station.correction.turn(),
        turn_rad: station.correction.turn_rad.length(),
        shift: station.correction.shift_m,
    };
    stations.iter().map(motion).collect()
}

/// Time and place along `stations`, about `apart_m` apart; more than [`MOST_PLACES`] are not all.
fn with_places(stations: &[Station], apart_m: f64, longest_s: f64) -> Vec<(f64, DVec3)> {
    let Some(first) = stations.first() else { return Vec::new() };
    let mut track = vec![(first.time_s, first.position)];
    let mut last = first.position;
    for pair in stations.windows(2) {
        let [before, after] = [pair[0], pair[1]];
        let time_s = after.time_s - before.time_s;
        let way_m = before.position.distance(after.position);
        let is_way = time_s <= longest_s;
        // However far apart two stations claim to be, there are no more places than are asked for.
        let parts =
            if is_way { (way_m / apart_m).ceil().clamp(1.0, MOST_PLACES as f64) } else { 1.0 };
        for part in 1..=parts as u32 {
            let t = f64::from(part) / parts;
            let place = before.position.lerp(after.position, t);
            if !is_way || place.distance(last) >= 0.5 * apart_m {
                track.push((before.time_s + t * time_s, place));
                last = place;
            }
        }
        if track.len() > MOST_PLACES {
            break;
        }
    }
    track
}

/// Of each point the run of places that it comes from: as few places in each as leave it, on
/// average, the points that are drawn together.
pub(super) fn runs(of_points: &[u16]) -> Vec<u16> {
    let most = of_points.len() / RUN_POINTS;
    let mut runs = of_points.to_vec();
    let mut seen = vec![false; usize::from(u16::MAX) + 1];
    loop {
        runs.iter().for_each(|&run| seen[usize::from(run)] = true);
        let distinct = seen.iter_mut().map(|seen| u32::from(std::mem::take(seen))).sum::<u32>();
        if distinct as usize <= most.max(1) {
            return runs;
        }
        runs.iter_mut().for_each(|run| *run >>= 1);
    }
}

#[cfg(test)]
mod tests;

//! Where a survey was when it took its points, from the points alone: a trajectory is seldom
//! delivered, but what a vehicle measures at one moment lies around it.

use std::collections::BTreeMap;
use std::sync::Mutex;

use flaneur_proto::v1;
use flaneur_scene::{Station, StationCorrection};
use glam::{DVec3, I64Vec3};

use super::scan::raw_position;

/// Most stations of a source. Where it was longer on its way they stand for longer times.
const MOST_STATIONS: usize = 4096;
/// The shortest time that a station stands for, seconds; others are this doubled.
const SHORTEST_S: f64 = 0.125;
/// Times are summed in steps of this, seconds: sums of whole numbers do not depend on the order.
const TIME_STEP_S: f64 = 1e-6;
/// No survey's clock is this far from zero, seconds.
const FARTHEST_TIME_S: f64 = 1e12;
/// Offset of the GPS time in records of formats 6, 7 and 8.
pub(super) const GPS_TIME: usize = 22;

/// Sums of the points of each moment; the same whatever the order of the points.
#[derive(Clone, Debug, Default)]
pub(super) struct Moments {
    /// How often the time of a moment was doubled.
    doublings: u32,
    /// By the number of the moment, counted from time 0.
    sums: BTreeMap<i64, Sum>,
}

/// Some points, summed: times in [`TIME_STEP_S`], raw coordinates.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    points: u64,
    time: i128,
    raw: [i128; 3],
}

/// The moments of a group of files, which several threads read.
#[derive(Debug, Default)]
pub(super) struct SharedMoments(Mutex<Moments>);

impl SharedMoments {
    /// Counts records of format 6, 7 or 8, of `length` bytes.
    pub(super) fn include(&self, records: &[u8], length: usize) {
        let moments = Moments::of(records, length);
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).merge(moments);
    }

    /// The stations of points with this scale and offset, ascending in time; none where the points do
    /// not differ in time.
    pub(super) fn stations(self, scale: DVec3, offset: DVec3) -> Vec<Station> {
        let moments = self.0.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        let mut stations: Vec<Station> = moments
            .sums
            .values()
            .map(|sum| {
                let mean = |total: i128| total as f64 / sum.points as f64;
                Station {
                    time_s: mean(sum.time) * TIME_STEP_S,
                    position: DVec3::from_array(sum.raw.map(mean)) * scale + offset,
                    correction: StationCorrection::default(),
                }
            })
            .collect();
        // Rounding could make neighbours equal.
        let time = v1::Stations::time_steps;
        stations.dedup_by(|next, before| time(next) <= time(before));
        if stations.len() < 2 { Vec::new() } else { stations }
    }
}

impl Moments {
    fn of(records: &[u8], length: usize) -> Self {
        let mut moments = Self::default();
        // Neighbours in a file are mostly of one moment.
        let mut current = (0, Sum::default());
        for record in records.chunks_exact(length) {
            let time_s = f64::from_le_bytes(std::array::from_fn(|i| record[GPS_TIME + i]));
            // Written so that NaN is passed over.
            if !(time_s.abs() <= FARTHEST_TIME_S) {
                continue;
            }
            let moment = (time_s / SHORTEST_S).floor() as i64 >> moments.doublings;
            if moment != current.0 {
                moments.add(current.0, &current.1);
                current =
                    ((time_s / SHORTEST_S).floor() as i64 >> moments.doublings, Sum::default());
            }
            current.1.include(time_s, raw_position(record).as_i64vec3());
        }
        moments.add(current.0, &current.1);
        moments
    }

    fn add(&mut self, moment: i64, sum: &Sum) {
        if sum.points == 0 {
            return;
        }
        self.sums.entry(moment).or_default().add(sum);
        while self.sums.len() > MOST_STATIONS {
            self.double();
        }
    }

    fn merge(&mut self, mut other: Self) {
        while self.doublings < other.doublings {
            self.double();
        }
        while other.doublings < self.doublings {
            other.double();
        }
        let doublings = self.doublings;
        for (moment, sum) in &other.sums {
            self.add(moment >> (self.doublings - doublings), sum);
        }
    }

    fn double(&mut self) {
        self.doublings += 1;
        for (moment, sum) in std::mem::take(&mut self.sums) {
            self.sums.entry(moment >> 1).or_default().add(&sum);
        }
    }
}

impl Sum {
    fn include(&mut self, time_s: f64, raw: I64Vec3) {
        let time = (time_s / TIME_STEP_S).round() as i128;
        let raw = raw.to_array().map(i128::from);
        self.add(&Self { points: 1, time, raw });
    }

    fn add(&mut self, other: &Self) {
        self.points += other.points;
        self.time += other.time;
        self.raw.iter_mut().zip(other.raw).for_each(|(sum, raw)| *sum += raw);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::IVec3;

    const SCALE: DVec3 = DVec3::splat(0.001);
    const OFFSET: DVec3 = DVec3::new(651_000.0, 6_861_000.0, 0.0);

    /// Records of format 6.
    fn records(points: impl IntoIterator<Item = (f64, IVec3)>) -> Vec<u8> {
        let record = |(time_s, raw): (f64, IVec3)| {
            let mut record = [0u8; 30];
            for (bytes, raw) in record.chunks_exact_mut(4).zip(raw.to_array()) {
                bytes.copy_from_slice(&raw.to_le_bytes());
            }
            record[GPS_TIME..].copy_from_slice(&time_s.to_le_bytes());
            record
        };
        points.into_iter().flat_map(record).collect()
    }

    fn stations_of<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> Vec<Station> {
        let moments = SharedMoments::default();
        parts.into_iter().for_each(|part| moments.include(part, 30));
        moments.stations(SCALE, OFFSET)
    }

    /// A vehicle at 10.24 m/s that measures 1024 points a second, on either side.
    fn drive(seconds: u32) -> impl Iterator<Item = (f64, IVec3)> {
        (0..1024 * seconds).map(|i| {
            let side = if i % 2 == 0 { 7000 } else { -7000 };
            (1.3e9 + f64::from(i) / 1024.0, IVec3::new(10 * i as i32, side, 2000))
        })
    }

    #[test]
    fn stations_are_where_the_vehicle_was() {
        let stations = stations_of([&*records(drive(60))]);
        assert_eq!(stations.len(), 60 * 8);
        for station in stations {
            let along_m = (station.time_s - 1.3e9) * 10.24;
            let off = station.position - OFFSET - DVec3::new(along_m, 0.0, 2.0);
            assert!(off.length() < 1e-3, "{station:?}: off by {off}");
        }
    }

    /// Three hours have stations of four seconds; the order and the parts do not matter.
    #[test]
    fn long_surveys_have_as_few_stations_whatever_the_order() {
        let survey: Vec<(f64, IVec3)> =
            (0..20_000).map(|i| (f64::from(i) * 0.54, IVec3::new(i, i % 7, -i))).collect();
        let whole = stations_of([&*records(survey.iter().copied())]);
        assert!((MOST_STATIONS / 2..=MOST_STATIONS).contains(&whole.len()), "{}", whole.len());
        let backwards = records(survey.iter().rev().copied());
        let parts: Vec<&[u8]> = backwards.chunks(30 * 777).collect();
        assert_eq!(stations_of(parts.iter().copied()), whole);
        assert_eq!(stations_of(parts.into_iter().rev()), whole);
    }

    #[test]
    fn points_without_times_have_no_stations() {
        let at = |time_s: f64| (time_s, IVec3::new(1, 2, 3));
        for times in [&[][..], &[0.0; 9], &[f64::NAN, f64::INFINITY, 5.0], &[1e300, -1e300]] {
            let records = records(times.iter().map(|time_s| at(*time_s)));
            assert_eq!(stations_of([&*records]), [], "{times:?}");
        }
    }

    #[test]
    fn hostile_times_end_in_few_stations_in_order() {
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            f64::from_bits(state)
        };
        let times = (0..50_000).map(|i| if i % 2 == 0 { next() } else { next() % 1e12 });
        let raw = |i: i32| if i % 2 == 0 { IVec3::MAX } else { IVec3::MIN };
        let stations = stations_of([&*records(times.zip(0..).map(|(t, i)| (t, raw(i))))]);
        assert!((2..=MOST_STATIONS).contains(&stations.len()), "{}", stations.len());
        assert!(stations.windows(2).all(|pair| pair[0].time_s < pair[1].time_s));
        assert!(stations.iter().all(|s| s.time_s.is_finite() && s.position.is_finite()));
        v1::Stations::try_from(&stations[..]).expect("they can be sent");
    }
}

use flaneur_scene::StationCorrection;

use super::*;
use proptest::prelude::*;

fn station(time_s: f64, x: f64) -> Station {
    let position = DVec3::new(651_000.0 + x, 6_861_000.0, 40.0);
    Station { time_s, position, correction: StationCorrection::default() }
}

fn place(track: &Track, time_s: f64) -> f64 {
    let stations = track.stations_of(&[time_s]);
    stations.of_point(0).expect("known").x - 651_000.0
}

/// A vehicle at 20 m/s with a station a second, standing still from 10 to 12 s.
#[test]
fn points_come_from_where_the_vehicle_was() {
    let way = |t: f64| 20.0 * t.min(10.0) + 20.0 * (t - 12.0).max(0.0);
    let stations: Vec<Station> =
        (0..=20).map(|i| station(f64::from(i), way(f64::from(i)))).collect();
    let track = Track::through(&stations);
    for time_s in [0.0, 0.3, 4.71, 9.99, 11.0, 13.5, 20.0] {
        let off_m = (place(&track, time_s) - way(time_s)).abs();
        assert!(off_m <= 0.5 * APART_M + 1e-9, "{time_s}: {off_m}");
    }
    assert_eq!((place(&track, -1e300), place(&track, 1e300)), (0.0, way(20.0)), "the ends");
    let unknown = track.stations_of(&[f64::NAN, f64::INFINITY]);
    assert_eq!(unknown.of_points, [PointStations::UNKNOWN; 2]);
    assert_eq!(unknown.of_point(0), None);
}

/// Two drives an hour apart: nobody was between them.
#[test]
fn breaks_are_no_way() {
    let drive = |start_s: f64, x: f64| {
        (0..9).map(move |i| station(start_s + f64::from(i), x + f64::from(i)))
    };
    let stations: Vec<Station> = drive(0.0, 0.0).chain(drive(3600.0, 500.0)).collect();
    let track = Track::through(&stations);
    let between = |p: &&DVec3| (10.0..499.0).contains(&(p.x - 651_000.0));
    assert_eq!(track.places.iter().find(between), None);
    assert_eq!(place(&track, 8.0), 8.0);
    assert_eq!(place(&track, 3600.0), 500.0);
}

#[test]
fn one_station_or_none_tells_nothing() {
    for stations in [&[][..], &[station(0.0, 0.0)]] {
        assert_eq!(Track::through(stations).stations_of(&[0.0; 5]), PointStations::default());
    }
}

#[test]
fn runs_have_enough_points() {
    let of_points: Vec<u16> = (0..4096).map(|i| i % 64).collect();
    let mut runs = runs(&of_points);
    assert!(runs.iter().zip(&of_points).all(|(run, place)| *run == place / 4));
    runs.sort_unstable();
    runs.dedup();
    assert_eq!(runs.len(), 4096 / RUN_POINTS);
    assert_eq!(super::runs(&[3, PointStations::UNKNOWN]), [0, 0]);
    assert!(super::runs(&[]).is_empty());
}

proptest! {
    /// Whatever the times and positions, there are few places, and every time has one of them.
    #[test]
    fn hostile_stations_are_survived(
        steps in prop::collection::vec((1e-9..1e9f64, -1e7..1e7f64), 0..40),
        asked in prop::num::f64::ANY,
    ) {
        let mut time_s = -1e9;
        let stations: Vec<Station> = steps
            .into_iter()
            .map(|(step, x)| {
                time_s += step;
                station(time_s, x)
            })
            .collect();
        let track = Track::through(&stations);
        prop_assert!(track.places.len() <= MOST_PLACES);
        prop_assert!(track.places.iter().all(|place| place.is_finite()));
        let of = track.stations_of(&[asked]);
        prop_assert_eq!(of.of_point(0).is_some(), track.places.len() > 1 && asked.is_finite());
    }
}

/// A turn of a degree about a station, and a shift; half way to one without, half of both.
#[test]
fn points_are_shown_where_their_stations_say() {
    let mut stations = [station(0.0, 0.0), station(1.0, 2.0), station(100.0, 3.0)];
    let nothing = Track::through(&stations);
    let pivot = stations[0].position;
    let place = pivot + DVec3::new(30.0, 0.0, 5.0);
    assert_eq!((nothing.shown(0.4, place), nothing.farthest_m(place)), (place, 0.0));
    stations[0].correction.turn_rad = DVec3::new(0.0, 0.0, 1f64.to_radians());
    stations[0].correction.shift_m = DVec3::new(0.1, 0.0, -0.2);
    let track = Track::through(&stations);
    let (sin, cos) = 1f64.to_radians().sin_cos();
    let moved = DVec3::new(30.0 * cos + 0.1, 30.0 * sin, 4.8) - DVec3::new(30.0, 0.0, 5.0);
    for (time_s, share) in [(-9.0, 1.0), (0.0, 1.0), (0.5, 0.5), (1.0, 0.0), (2.0, 0.0)] {
        let off = track.shown(time_s, place) - place - share * moved;
        assert!(off.length() < 1e-8, "{time_s}: {off}");
        assert!((share * moved).length() <= track.farthest_m(place));
    }
    assert_eq!(track.shown(f64::NAN, place), place, "nobody knows when it was");
    assert!((track.places[0] - pivot - DVec3::new(0.1, 0.0, -0.2)).length() < 1e-8);
}

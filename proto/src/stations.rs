//! Where point sources were taken from.

use flaneur_scene::Station;
use glam::DVec3;

use crate::error::FieldError;
use crate::v1;

/// Most stations of a point source.
const MAX_STATIONS: usize = 1 << 16;

/// Steps of a second in which times are sent.
const STEPS_A_SECOND: f64 = 1e6;

/// Steps of a metre in which coordinates are sent.
const STEPS_A_METRE: f64 = 1e3;

/// Numbers are within so many steps of 0.
const FARTHEST_TIME: i64 = 1_000_000_000_000_000_000;
const FARTHEST_COORDINATE: i64 = 1_000_000_000_000_000;

impl v1::Stations {
    /// The time of a station in the steps in which it is sent. Two stations must differ in it.
    pub fn time_steps(station: &Station) -> i64 {
        // The cast saturates; NaN is 0.
        (station.time_s * STEPS_A_SECOND).round() as i64
    }
}

impl TryFrom<&[Station]> for v1::Stations {
    type Error = FieldError;

    /// An error names a station that does not follow the one before it in time, or lies nowhere.
    fn try_from(stations: &[Station]) -> Result<Self, FieldError> {
        let mut message = Self::default();
        let mut before = [0; 4];
        for (index, station) in stations.iter().enumerate() {
            let DVec3 { x, y, z } = station.position * STEPS_A_METRE;
            let steps = [station.time_s * STEPS_A_SECOND, x, y, z].map(f64::round);
            let [time, x, y, z] = steps;
            let is_somewhere = time.abs() <= FARTHEST_TIME as f64
                && [x, y, z].iter().all(|c| c.abs() <= FARTHEST_COORDINATE as f64);
            let now = steps.map(|value| value as i64);
            if !is_somewhere || (index > 0 && now[0] <= before[0]) {
                let problem = format!("is {station:?}, after {:?}", index.checked_sub(1));
                return Err(FieldError::new(format!("stations[{index}]"), problem));
            }
            message.time_steps_us.push(now[0] - before[0]);
            message.x_steps_mm.push(now[1] - before[1]);
            message.y_steps_mm.push(now[2] - before[2]);
            message.z_steps_mm.push(now[3] - before[3]);
            before = now;
        }
        Ok(message)
    }
}

impl TryFrom<v1::Stations> for Vec<Station> {
    type Error = FieldError;

    fn try_from(message: v1::Stations) -> Result<Self, FieldError> {
        let count = message.time_steps_us.len();
        if count > MAX_STATIONS {
            let problem = format!("holds {count}, at most {MAX_STATIONS}");
            return Err(FieldError::new("time_steps_us", problem));
        }
        let lists = [&message.x_steps_mm, &message.y_steps_mm, &message.z_steps_mm];
        for (field, list) in COORDINATES.iter().zip(lists) {
            if list.len() != count {
                let problem = format!("holds {}, for {count} times", list.len());
                return Err(FieldError::new(*field, problem));
            }
        }
        let mut stations = Self::with_capacity(count);
        let mut before = [0_i64; 4];
        let positions = lists[0].iter().zip(lists[1]).zip(lists[2]);
        for (index, (time, ((x, y), z))) in message.time_steps_us.iter().zip(positions).enumerate()
        {
            let add = |field: &str, before: i64, step: i64, farthest: i64| {
                before
                    .checked_add(step)
                    .filter(|sum| (-farthest..=farthest).contains(sum))
                    .ok_or_else(|| {
                        let problem = format!("is {step} after {before}, beyond {farthest}");
                        FieldError::new(format!("{field}[{index}]"), problem)
                    })
            };
            if index > 0 && *time <= 0 {
                let problem = format!("is {time}, must be more than 0");
                return Err(FieldError::new(format!("time_steps_us[{index}]"), problem));
            }
            let now = [
                add("time_steps_us", before[0], *time, FARTHEST_TIME)?,
                add(COORDINATES[0], before[1], *x, FARTHEST_COORDINATE)?,
                add(COORDINATES[1], before[2], *y, FARTHEST_COORDINATE)?,
                add(COORDINATES[2], before[3], *z, FARTHEST_COORDINATE)?,
            ];
            let [time, x, y, z] = now.map(|steps| steps as f64);
            let position = DVec3::new(x, y, z) / STEPS_A_METRE;
            stations.push(Station { time_s: time / STEPS_A_SECOND, position });
            before = now;
        }
        Ok(stations)
    }
}

/// The lists of coordinates.
const COORDINATES: [&str; 3] = ["x_steps_mm", "y_steps_mm", "z_steps_mm"];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn station(time_s: f64, x: f64) -> Station {
        Station { time_s, position: DVec3::new(x, 6.86e6, 30.0) }
    }

    fn drive() -> v1::Stations {
        let stations = [station(-1.5, 651_000.0), station(1.3e9, 651_003.0)];
        v1::Stations::try_from(&stations[..]).expect("ascending")
    }

    #[test]
    fn faults_are_named() {
        let field = |change: fn(&mut v1::Stations)| {
            let mut message = drive();
            change(&mut message);
            Vec::<Station>::try_from(message).expect_err("bad stations").field
        };
        assert_eq!(field(|m| m.time_steps_us[1] = 0), "time_steps_us[1]");
        assert_eq!(field(|m| m.time_steps_us[1] = -5), "time_steps_us[1]");
        assert_eq!(field(|m| m.time_steps_us[1] = i64::MAX), "time_steps_us[1]");
        assert_eq!(field(|m| m.time_steps_us[0] = i64::MIN), "time_steps_us[0]");
        assert_eq!(field(|m| m.y_steps_mm[1] = i64::MAX), "y_steps_mm[1]");
        assert_eq!(field(|m| m.x_steps_mm.push(1)), "x_steps_mm");
        assert_eq!(field(|m| m.z_steps_mm.clear()), "z_steps_mm");
        assert_eq!(field(|m| m.time_steps_us = vec![1; MAX_STATIONS + 1]), "time_steps_us");
    }

    #[test]
    fn what_does_not_ascend_or_lies_nowhere_is_not_sent() {
        let fault = |second| {
            v1::Stations::try_from(&[station(1.0, 2.0), second][..]).expect_err("bad").field
        };
        for bad in [
            station(1.0, 5.0),
            station(1.000_000_4, 5.0),
            station(f64::NAN, 5.0),
            station(2.0, f64::NAN),
            station(2.0, 1e300),
            station(f64::INFINITY, 1.0),
        ] {
            assert_eq!(fault(bad), "stations[1]", "{bad:?}");
        }
    }

    /// As two messages a station they took 38.
    #[test]
    fn a_station_takes_about_ten_bytes() {
        let along = |i: u32| station(1.3e9 + 0.125 * f64::from(i), 651_000.0 + 1.2 * f64::from(i));
        let stations: Vec<Station> = (0..4096).map(along).collect();
        let message = v1::Stations::try_from(&stations[..]).expect("ascending");
        assert!(prost::Message::encoded_len(&message) < 10 * stations.len());
    }

    proptest! {
        #[test]
        fn stations_come_back_to_half_a_step(
            start in -1e9..2e9f64,
            way in prop::collection::vec((1e-5..1e4f64, prop::array::uniform3(-9e6..9e6f64)), 0..50),
        ) {
            let mut time_s = start;
            let sent: Vec<Station> = way.into_iter().map(|(step_s, place)| {
                time_s += step_s;
                Station { time_s, position: DVec3::from_array(place) }
            }).collect();
            let message = v1::Stations::try_from(&sent[..]).expect("ascending");
            let back = Vec::<Station>::try_from(message).expect("valid");
            prop_assert_eq!(back.len(), sent.len());
            for (back, sent) in back.iter().zip(&sent) {
                // Half a step, and what an f64 of these times cannot say.
                prop_assert!((back.time_s - sent.time_s).abs() <= 0.5e-6 + 2.5e-7);
                let off_m = (back.position - sent.position).abs().max_element();
                prop_assert!(off_m <= 0.5e-3 + 2e-9, "{off_m}");
            }
        }
    }
}

//! Where point sources were taken from.

use flaneur_scene::{Station, StationCorrection};
use glam::DVec3;

use crate::error::FieldError;
use crate::v1;

/// Most stations of a point source.
const MAX_STATIONS: usize = 1 << 16;

/// Steps of a second in which times are sent.
const STEPS_A_SECOND: f64 = 1e6;

/// Steps of a metre in which coordinates are sent.
const STEPS_A_METRE: f64 = 1e3;

/// Steps of a radian in which turns are sent, and of a metre in which shifts are.
const STEPS_A_RADIAN: f64 = 1e9;
const STEPS_A_SHIFTED_METRE: f64 = 1e5;

/// A correction is six numbers, each within so many steps of 0.
const CORRECTION: usize = 6;
const FARTHEST_TURN: i64 = 500_000_000;
const FARTHEST_SHIFT: i64 = 10_000_000;

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
        message.correction_steps = correction_steps(stations)?;
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
        let corrections = corrections(&message.correction_steps, count)?;
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
            let correction = corrections.get(index).copied().unwrap_or_default();
            stations.push(Station { time_s: time / STEPS_A_SECOND, position, correction });
            before = now;
        }
        Ok(stations)
    }
}

/// What is sent of the corrections, nothing where there are none; an error names one that is no small
/// motion.
fn correction_steps(stations: &[Station]) -> Result<Vec<i64>, FieldError> {
    let mut sent = Vec::new();
    if stations.iter().all(|station| station.correction.is_none()) {
        return Ok(sent);
    }
    let mut before = [0; CORRECTION];
    for (index, Station { correction, .. }) in stations.iter().enumerate() {
        let turn = correction.turn_rad * STEPS_A_RADIAN;
        let shift = correction.shift_m * STEPS_A_SHIFTED_METRE;
        let steps = [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z].map(f64::round);
        let farthest = |k: usize| if k < 3 { FARTHEST_TURN } else { FARTHEST_SHIFT };
        // Written so that NaN is refused.
        if !(0..CORRECTION).all(|k| steps[k].abs() <= farthest(k) as f64) {
            let problem = format!("is {correction:?}, no small motion");
            return Err(FieldError::new(format!("stations[{index}].correction"), problem));
        }
        let now = steps.map(|steps| steps as i64);
        sent.extend(now.iter().zip(before).map(|(now, before)| now - before));
        before = now;
    }
    Ok(sent)
}

/// The corrections of `count` stations, or none.
fn corrections(sent: &[i64], count: usize) -> Result<Vec<StationCorrection>, FieldError> {
    if !sent.is_empty() && sent.len() != CORRECTION * count {
        let problem = format!("holds {}, for {count} stations", sent.len());
        return Err(FieldError::new("correction_steps", problem));
    }
    let mut now = [0_i64; CORRECTION];
    let mut found = Vec::with_capacity(sent.len() / CORRECTION);
    for (index, step) in sent.iter().enumerate() {
        let (sum, farthest) = match index % CORRECTION {
            k @ 0..3 => (&mut now[k], FARTHEST_TURN),
            k => (&mut now[k], FARTHEST_SHIFT),
        };
        *sum = sum
            .checked_add(*step)
            .filter(|sum| (-farthest..=farthest).contains(sum))
            .ok_or_else(|| {
                let problem = format!("is {step} after {sum}, beyond {farthest}");
                FieldError::new(format!("correction_steps[{index}]"), problem)
            })?;
        if index % CORRECTION == CORRECTION - 1 {
            let [tx, ty, tz, x, y, z] = now.map(|steps| steps as f64);
            found.push(StationCorrection {
                turn_rad: DVec3::new(tx, ty, tz) / STEPS_A_RADIAN,
                shift_m: DVec3::new(x, y, z) / STEPS_A_SHIFTED_METRE,
            });
        }
    }
    Ok(found)
}

/// The lists of coordinates.
const COORDINATES: [&str; 3] = ["x_steps_mm", "y_steps_mm", "z_steps_mm"];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn station(time_s: f64, x: f64) -> Station {
        let position = DVec3::new(x, 6.86e6, 30.0);
        Station { time_s, position, correction: StationCorrection::default() }
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
        assert_eq!(field(|m| m.correction_steps = vec![0; 6]), "correction_steps");
        assert_eq!(field(|m| m.correction_steps = vec![i64::MAX; 12]), "correction_steps[0]");
        let twice = |m: &mut v1::Stations| {
            m.correction_steps = vec![0; 12];
            m.correction_steps[0] = 300_000_000;
            m.correction_steps[6] = 300_000_000;
        };
        assert_eq!(field(twice), "correction_steps[6]");
        assert_eq!(field(|m| m.correction_steps = vec![6_000_000; 12]), "correction_steps[9]");
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

    #[test]
    fn corrections_come_back_and_large_ones_are_not_sent() {
        let mut stations = [station(1.0, 2.0), station(2.0, 3.0)];
        stations[1].correction.turn_rad = DVec3::new(0.024, -1e-9, 0.0);
        stations[1].correction.shift_m = DVec3::new(-0.15, 0.0, 1e-5);
        let message = v1::Stations::try_from(&stations[..]).expect("small motions");
        let back = Vec::<Station>::try_from(message).expect("valid");
        for (back, sent) in back.iter().zip(&stations) {
            assert!((back.correction.turn_rad - sent.correction.turn_rad).length() < 1e-9);
            assert!((back.correction.shift_m - sent.correction.shift_m).length() < 1e-5);
        }
        for turn in [0.6, f64::NAN] {
            stations[0].correction.turn_rad.z = turn;
            let fault = v1::Stations::try_from(&stations[..]).expect_err("no small motion").field;
            assert_eq!(fault, "stations[0].correction");
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
                Station {
                    time_s,
                    position: DVec3::from_array(place),
                    correction: StationCorrection::default(),
                }
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

use flaneur_scene::StationCorrection;

use super::*;

fn station(x: f64) -> Station {
    let position = DVec3::new(651_000.0 + x, 6_861_000.0, 40.0);
    Station { time_s: x, position, correction: StationCorrection::default() }
}

fn pose(x: f64, turn_rad: f64, shift: f64) -> DeliveredPose {
    DeliveredPose {
        panorama: x.to_string(),
        position: station(x).position + DVec3::new(0.0, 1.0, 2.0),
        world_from_rig: DMat3::IDENTITY.to_cols_array_2d(),
        turn_rad: DVec3::new(0.0, 0.0, turn_rad),
        shift_m: DVec3::new(0.0, 0.0, shift),
    }
}

/// Where a station's correction has what the survey has at `place`.
fn moved(station: &Station, place: DVec3) -> DVec3 {
    let StationCorrection { shift_m, .. } = station.correction;
    station.correction.turn() * (place - station.position) + station.position + shift_m
}

/// One correction for all: every point moves as the pose nearest to it does.
#[test]
fn points_move_as_the_poses_around_do() {
    let poses: Vec<DeliveredPose> = (0..9).map(|i| pose(f64::from(i), 0.02, 0.1)).collect();
    let found = corrected(&[station(4.0), station(100.0)], &poses);
    let middle = poses[4].position;
    let place = middle + DVec3::new(3.0, 20.0, 5.0);
    let wanted =
        DMat3::from_rotation_z(0.02) * (place - middle) + middle + DVec3::new(0.0, 0.0, 0.1);
    let off = moved(&found[0], place).distance(wanted);
    assert!(off < 1e-6, "{off}");
    assert!(found[1].correction.is_none(), "80 m from the last pose");
}

#[test]
fn corrections_fade_between_poses_and_away_from_them() {
    let poses = [pose(0.0, 0.0, 0.1), pose(8.0, 0.0, 0.3)];
    let shift = |x: f64| corrected(&[station(x)], &poses)[0].correction.shift_m.z;
    assert!((shift(4.0) - 0.2).abs() < 1e-9, "{}", shift(4.0));
    let way: Vec<f64> = (0..=80).map(|i| shift(0.1 * f64::from(i))).collect();
    assert!(way.windows(2).all(|pair| pair[0] <= pair[1] && pair[1] - pair[0] < 0.02), "{way:?}");
    let away: Vec<f64> = (0..30).map(|i| shift(8.0 + f64::from(i))).collect();
    assert!(away[0] > 0.29 && (away[5] - 0.3).abs() < 1e-3 && away[25] == 0.0, "{away:?}");
}

//! The rotation that heading, pitch and roll stand for.

use glam::DMat3;

/// `R_world_from_rig = Rz(−heading) · Rx(pitch) · Ry(roll)`, angles in radians.
///
/// Heading is clockwise from grid north, a positive pitch looks up, and a
/// positive roll lowers the right side. With all three zero the rig looks
/// north: its axes (right, forward, up) are the world's (east, north, up).
pub fn world_from_rig(heading: f64, pitch: f64, roll: f64) -> DMat3 {
    DMat3::from_rotation_z(-heading) * DMat3::from_rotation_x(pitch) * DMat3::from_rotation_y(roll)
}

/// Heading, pitch and roll in radians, the inverse of [`world_from_rig`]: heading in
/// [0, 2π), pitch in ±π/2, roll in ±π.
///
/// Looking straight up or down, heading and roll turn about the same axis: roll is then 0
/// and the heading carries both.
pub fn heading_pitch_roll(world_from_rig: &DMat3) -> [f64; 3] {
    let [right, forward, up] =
        [world_from_rig.x_axis, world_from_rig.y_axis, world_from_rig.z_axis];
    let cos_pitch = forward.x.hypot(forward.y);
    let pitch = forward.z.atan2(cos_pitch);
    // Below this the heading of `forward` is rounding noise.
    let (heading, roll) = if cos_pitch > 1e-12 {
        (forward.x.atan2(forward.y), (-right.z).atan2(up.z))
    } else {
        ((-right.y).atan2(right.x), 0.0)
    };
    [heading.rem_euclid(std::f64::consts::TAU), pitch, roll]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn heading_east_looks_east_and_pitch_looks_up() {
        let east = world_from_rig(FRAC_PI_2, 0.0, 0.0) * DVec3::Y;
        assert!(east.distance(DVec3::X) < 1e-15, "{east}");
        let up = world_from_rig(0.3, FRAC_PI_2, 0.0) * DVec3::Y;
        assert!(up.distance(DVec3::Z) < 1e-15, "{up}");
        let right = world_from_rig(0.0, 0.0, 0.1) * DVec3::X;
        assert!(right.z < 0.0, "{right}");
    }

    proptest! {
        /// Within 1e-9 of a pole the angles lose digits, so the rotations are compared.
        #[test]
        fn angles_round_trip(
            heading in -7.0..7.0, pitch in -FRAC_PI_2..FRAC_PI_2, roll in -3.1..3.1,
        ) {
            let rotation = world_from_rig(heading, pitch, roll);
            let [h, p, r] = heading_pitch_roll(&rotation);
            prop_assert!((0.0..std::f64::consts::TAU).contains(&h));
            let difference = (world_from_rig(h, p, r) - rotation).abs();
            prop_assert!(difference.to_cols_array().iter().all(|d| *d < 1e-12), "{difference}");
        }
    }

    #[test]
    fn at_the_poles_the_heading_carries_the_roll() {
        for pitch in [FRAC_PI_2, -FRAC_PI_2] {
            let rotation = world_from_rig(0.4, pitch, 0.3);
            let [h, p, r] = heading_pitch_roll(&rotation);
            assert_eq!(r, 0.0);
            let difference = world_from_rig(h, p, r) - rotation;
            // cos(π/2) is 6e-17 in f64, so the pole itself is only that exact.
            assert!(
                difference.to_cols_array().iter().all(|d| d.abs() < 1e-12),
                "{h} {p} {difference}"
            );
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
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
}

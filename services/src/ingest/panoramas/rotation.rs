//! Matrices that claim to be rotations.

use glam::DMat3;

/// Largest entry of `|MᵀM − I|` that is taken for rounding. Calibrations are published with
/// six digits or so, which leaves 1e-6; 1e-3 is 0.06° of shear.
pub(super) const TOLERANCE: f64 = 1e-3;

/// The rotation nearest to `m` (its polar factor), or the deviation `max |MᵀM − I|` where
/// that exceeds [`TOLERANCE`]; a reflection deviates by 2, what is not finite by infinity.
pub(super) fn nearest(m: DMat3) -> Result<DMat3, f64> {
    let deviation = deviation(m);
    if !(deviation <= TOLERANCE) {
        return Err(deviation);
    }
    // Newton's iteration for the polar factor converges quadratically: from 1e-3, three
    // steps reach the rounding of f64.
    Ok((0..4).fold(m, |r, _| (r + r.transpose().inverse()) * 0.5))
}

fn deviation(m: DMat3) -> f64 {
    if !m.is_finite() {
        return f64::INFINITY;
    }
    let error = m.transpose() * m - DMat3::IDENTITY;
    let largest = error.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
    if m.determinant() < 0.0 { largest.max(2.0) } else { largest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::world_from_rig;
    use glam::DVec3;

    #[test]
    fn small_deviations_are_mended() {
        let exact = world_from_rig(1.0, -0.3, 0.2);
        let rounded =
            DMat3::from_cols_array(&exact.to_cols_array().map(|x| (x * 1e5).round() / 1e5));
        let mended = nearest(rounded).expect("rounding");
        assert!(deviation(mended) < 1e-15, "{}", deviation(mended));
        let moved = (mended - exact).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        assert!(moved < 1e-5, "{moved}");
    }

    #[test]
    fn what_is_no_rotation_is_refused_with_its_deviation() {
        let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.01, 1.0, 0.0), DVec3::Z);
        let deviation = nearest(sheared).expect_err("sheared");
        assert!((deviation - 0.01).abs() < 1e-12, "{deviation}");
        assert_eq!(nearest(-DMat3::IDENTITY), Err(2.0));
        assert_eq!(nearest(DMat3::ZERO), Err(1.0));
        assert_eq!(nearest(DMat3::IDENTITY * f64::NAN), Err(f64::INFINITY));
    }
}

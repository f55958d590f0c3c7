//! Lens distortion: from ideal pinhole pixels to the pixels of the photograph.

use glam::DVec2;
use serde::{Deserialize, Serialize};

/// How a lens departs from the pinhole, and how far its model can be trusted.
///
/// Each model maps normalised pinhole coordinates (x/z, y/z) to distorted ones,
/// except [`Distortion::RadialPixels`], which works on calibration pixels.
/// Beyond the radius where the radial polynomial stops growing it would fold
/// the picture back on itself: such points are outside the image, not mirrored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case")]
pub enum Distortion {
    /// An ideal pinhole.
    #[default]
    None,
    /// `p_raw = c + v (1 + k₀ r² + k₁ r⁴ + k₂ r⁶)`, `v = p − c`, `r = |v|`, in pixels
    /// of the lens's own size, valid while `r < limit_px` (the r³r⁵r⁷ model of iTowns).
    RadialPixels {
        /// Centre of distortion (principal point of symmetry), pixels.
        centre: DVec2,
        /// Coefficients of r², r⁴, r⁶, in pixels to the power −2, −4, −6.
        k: [f64; 3],
        /// Radius in ideal pixels beyond which the model does not hold.
        limit_px: f64,
    },
    /// Brown–Conrady on normalised coordinates: radial `1 + k₀ r² + k₁ r⁴ + k₂ r⁶`
    /// and tangential `p` (OpenCV's order k1, k2, p1, p2, k3; COLMAP's RADIAL and OPENCV).
    Brown {
        /// Radial coefficients of r², r⁴, r⁶.
        k: [f64; 3],
        /// Tangential coefficients p1, p2.
        p: [f64; 2],
    },
    /// Kannala–Brandt: `θ_d = θ (1 + k₀ θ² + k₁ θ⁴ + k₂ θ⁶ + k₃ θ⁸)`, `θ = atan r`
    /// (COLMAP's OPENCV_FISHEYE).
    Fisheye {
        /// Coefficients of θ², θ⁴, θ⁶, θ⁸.
        k: [f64; 4],
    },
}

impl Distortion {
    /// The ideal radius at which the model folds back or stops holding: pixels for
    /// [`Distortion::RadialPixels`], normalised units (tan θ) otherwise, infinite
    /// where it holds everywhere. Tangential terms are left out of the search.
    pub fn limit(&self) -> f64 {
        match *self {
            Self::None => f64::INFINITY,
            Self::RadialPixels { k, limit_px, .. } => {
                limit_px.min(first_turning_point(&[k[0], k[1], k[2]]))
            }
            Self::Brown { k, .. } => first_turning_point(&k),
            Self::Fisheye { k } => {
                let theta = first_turning_point(&k).min(std::f64::consts::FRAC_PI_2);
                if theta >= std::f64::consts::FRAC_PI_2 { f64::INFINITY } else { theta.tan() }
            }
        }
    }

    /// The distorted position of the ideal position `p`, or `None` at or beyond the limit.
    ///
    /// Units as in [`Distortion::limit`].
    pub fn distort(&self, p: DVec2) -> Option<DVec2> {
        let v = match *self {
            Self::RadialPixels { centre, .. } => p - centre,
            _ => p,
        };
        // Written so that NaN is refused.
        if !(v.length() < self.limit()) && !matches!(self, Self::None) {
            return None;
        }
        p.is_finite().then(|| self.distort_unchecked(p))
    }

    /// The ideal position of the distorted position `q`, or `None` where no position
    /// within the limit maps there. Newton on the full model, to 1e-12 relative.
    pub fn undistort(&self, q: DVec2) -> Option<DVec2> {
        if !q.is_finite() {
            return None;
        }
        let mut p = match *self {
            Self::None => return Some(q),
            Self::RadialPixels { centre, k, .. } => {
                let v = q - centre;
                centre + v * radial_inverse_scale(&k, v.length(), self.limit())?
            }
            Self::Brown { k, .. } => q * radial_inverse_scale(&k, q.length(), self.limit())?,
            Self::Fisheye { k } => {
                let theta_d = q.length();
                if theta_d == 0.0 {
                    return Some(q);
                }
                let limit = self.limit().atan();
                let theta = theta_d * radial_inverse_scale(&k, theta_d, limit)?;
                // Strictly inside a half turn: tan must be finite and positive.
                return (theta < limit && theta < std::f64::consts::FRAC_PI_2)
                    .then(|| q * (theta.tan() / theta_d));
            }
        };
        if let Self::Brown { p: tangential, .. } = *self
            && tangential != [0.0, 0.0]
        {
            p = self.newton(p, q)?;
        }
        // A solution of the equation only counts where the forward model accepts it.
        let back = self.distort(p)?;
        (back.distance(q) <= 1e-9 * (1.0 + q.length())).then_some(p)
    }

    fn distort_unchecked(&self, p: DVec2) -> DVec2 {
        match *self {
            Self::None => p,
            Self::RadialPixels { centre, k, .. } => {
                let v = p - centre;
                centre + v * radial_scale(&k, v.length_squared())
            }
            Self::Brown { k, p: [p1, p2] } => {
                let r2 = p.length_squared();
                let tangential = DVec2::new(
                    2.0 * p1 * p.x * p.y + p2 * (r2 + 2.0 * p.x * p.x),
                    p1 * (r2 + 2.0 * p.y * p.y) + 2.0 * p2 * p.x * p.y,
                );
                p * radial_scale(&k, r2) + tangential
            }
            Self::Fisheye { k } => {
                let r = p.length();
                if r == 0.0 {
                    return p;
                }
                let theta = r.atan();
                p * (theta * radial_scale(&k, theta * theta) / r)
            }
        }
    }

    /// Newton on the plane with the Jacobian by central differences of the model itself:
    /// only the tangential terms, which are small, are left for it to find.
    fn newton(&self, mut p: DVec2, q: DVec2) -> Option<DVec2> {
        for _ in 0..50 {
            let error = self.distort_unchecked(p) - q;
            if error.length() <= 1e-13 * (1.0 + q.length()) {
                break;
            }
            let h = 1e-6 * (1.0 + p.length());
            let dx = (self.distort_unchecked(p + DVec2::X * h)
                - self.distort_unchecked(p - DVec2::X * h))
                / (2.0 * h);
            let dy = (self.distort_unchecked(p + DVec2::Y * h)
                - self.distort_unchecked(p - DVec2::Y * h))
                / (2.0 * h);
            let jacobian = glam::DMat2::from_cols(dx, dy);
            if jacobian.determinant().abs() < 1e-12 {
                return None;
            }
            p -= jacobian.inverse() * error;
        }
        p.is_finite().then_some(p)
    }
}

/// `1 + k₀ r² + k₁ r⁴ + …`, by Horner's rule.
fn radial_scale(k: &[f64], r2: f64) -> f64 {
    1.0 + k.iter().rev().fold(0.0, |sum, &c| (sum + c) * r2)
}

/// The smallest r > 0 where `r (1 + k₀ r² + …)` stops growing; infinite if it never does.
///
/// Its derivative is a polynomial in s = r², `1 + 3 k₀ s + 5 k₁ s² + 7 k₂ s³ + …`. Its first
/// positive root is bracketed between the stationary points found recursively, so that
/// none is stepped over.
fn first_turning_point(k: &[f64]) -> f64 {
    let mut coefficients = vec![1.0];
    coefficients.extend(k.iter().zip(1..).map(|(c, i)| c * f64::from(2 * i + 1)));
    positive_roots(&coefficients).first().map_or(f64::INFINITY, |s| s.sqrt())
}

/// All positive roots of `c₀ + c₁ s + …`, ascending, each to full precision by bisection
/// between consecutive stationary points.
fn positive_roots(c: &[f64]) -> Vec<f64> {
    let Some(degree) = c.iter().rposition(|&x| x != 0.0) else { return Vec::new() };
    if degree == 0 || c.iter().any(|x| !x.is_finite()) {
        return Vec::new();
    }
    let c = &c[..=degree];
    let evaluate = |s: f64| c.iter().rev().fold(0.0, |sum: f64, &x| sum.mul_add(s, x));
    let derivative: Vec<f64> = c[1..].iter().zip(1..).map(|(x, i)| x * f64::from(i)).collect();
    // Cauchy's bound: every root lies within it.
    let bound = 1.0 + c[..degree].iter().map(|x| (x / c[degree]).abs()).fold(0.0, f64::max);
    let mut edges = vec![0.0];
    edges.extend(positive_roots(&derivative).into_iter().filter(|&s| s < bound));
    edges.push(bound);
    let mut roots = Vec::new();
    for pair in edges.windows(2) {
        let (mut low, mut high) = (pair[0], pair[1]);
        let sign = evaluate(low) > 0.0;
        if sign == (evaluate(high) > 0.0) {
            continue;
        }
        for _ in 0..2000 {
            let middle = low.midpoint(high);
            if middle <= low || middle >= high {
                break;
            }
            if (evaluate(middle) > 0.0) == sign { low = middle } else { high = middle }
        }
        if low > 0.0 {
            roots.push(low);
        }
    }
    roots
}

/// `r / q` where `r (1 + k₀ r² + …) = q` and `r < limit`, or `None`.
///
/// The radius grows on [0, limit), so bisection safeguards Newton.
fn radial_inverse_scale(k: &[f64], q: f64, limit: f64) -> Option<f64> {
    if q == 0.0 {
        return Some(1.0);
    }
    let forward = |r: f64| r * radial_scale(k, r * r);
    let mut high = if limit.is_finite() { limit } else { q.max(1e-300) };
    if limit.is_finite() {
        if forward(high) <= q {
            return None;
        }
    } else {
        while forward(high) < q {
            high *= 2.0;
            if !high.is_finite() {
                return None;
            }
        }
    }
    let (mut low, mut r) = (0.0, q.min(high));
    for _ in 0..200 {
        let error = forward(r) - q;
        if error > 0.0 {
            high = r;
        } else {
            low = r;
        }
        if error.abs() <= 1e-15 * q || high - low <= f64::EPSILON * high {
            break;
        }
        let slope = 1.0
            + k.iter()
                .zip(1..)
                .fold(0.0, |sum, (&c, i)| sum + c * f64::from(2 * i + 1) * r.powi(2 * i));
        let next = r - error / slope;
        r = if next > low && next < high { next } else { low.midpoint(high) };
    }
    Some(r / q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PARIS: Distortion = Distortion::RadialPixels {
        centre: DVec2::new(1042.178, 1027.565),
        k: [-1.337_915_876_037_518e-7, 3.475_409_773_283_144e-14, -4.441_039_859_188_881e-21],
        limit_px: 2079.0,
    };

    #[test]
    fn folding_is_refused_not_mirrored() {
        // 1 − r²: grows until r = 1/√3, then folds.
        let lens = Distortion::Brown { k: [-1.0, 0.0, 0.0], p: [0.0; 2] };
        let limit = lens.limit();
        assert!((limit - 1.0 / 3f64.sqrt()).abs() < 1e-12, "{limit}");
        assert!(lens.distort(DVec2::new(limit * 0.999, 0.0)).is_some());
        assert!(lens.distort(DVec2::new(limit * 1.001, 0.0)).is_none());
        assert!(lens.undistort(DVec2::new(0.5, 0.0)).is_none());
        assert!(lens.distort(DVec2::NAN).is_none());
        assert!(lens.undistort(DVec2::new(f64::NAN, 0.0)).is_none());
    }

    proptest! {
        #[test]
        fn radial_pixels_round_trip(x in 0.0..2048.0, y in 0.0..2048.0) {
            let q = DVec2::new(x, y);
            let p = PARIS.undistort(q).expect("inside the image");
            let back = PARIS.distort(p).expect("inside the limit");
            prop_assert!(back.distance(q) < 1e-9, "{q} {p} {back}");
        }

        #[test]
        fn brown_round_trip(
            x in -0.8..0.8, y in -0.8..0.8,
            k1 in -0.2..0.2, k2 in -0.05..0.05, p1 in -0.01..0.01, p2 in -0.01..0.01,
        ) {
            let lens = Distortion::Brown { k: [k1, k2, 0.0], p: [p1, p2] };
            let p = DVec2::new(x, y);
            if p.length() < 0.8 * lens.limit() {
                let q = lens.distort(p).expect("inside the limit");
                let back = lens.undistort(q).expect("in range");
                prop_assert!(back.distance(p) < 1e-8, "{p} {q} {back}");
            }
        }

        #[test]
        fn fisheye_round_trip(
            theta in 0.0..1.5, phi in 0.0..6.3, k1 in -0.05..0.05, k2 in -0.01..0.01,
        ) {
            let lens = Distortion::Fisheye { k: [k1, k2, 0.0, 0.0] };
            let p = DVec2::from_angle(phi) * f64::tan(theta);
            if p.length() < 0.99 * lens.limit() {
                let q = lens.distort(p).expect("inside the limit");
                let back = lens.undistort(q).expect("in range");
                prop_assert!(back.distance(p) < 1e-7 * (1.0 + p.length_squared()), "{p} {back}");
            }
        }
    }
}

//! Lens distortion: from ideal pinhole pixels to the pixels of the photograph.

mod radial;

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use radial::{first_turning_point, grows_until, inverse_scale, scale};

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
                let theta = first_turning_point(&k).min(FRAC_PI_2);
                if theta >= FRAC_PI_2 { f64::INFINITY } else { theta.tan() }
            }
        }
    }

    /// The distorted position of the ideal position `p`, or `None` at or beyond the limit.
    ///
    /// Units as in [`Distortion::limit`].
    pub fn distort(&self, p: DVec2) -> Option<DVec2> {
        // Cheaper than comparing with `limit`, which searches for it: ray tracers ask a
        // million times a frame. Comparisons are written so that NaN is refused.
        let holds = match *self {
            Self::None => true,
            Self::RadialPixels { centre, k, limit_px } => {
                let r = p.distance(centre);
                r < limit_px && grows_until(&k, r)
            }
            Self::Brown { k, .. } => grows_until(&k, p.length()),
            Self::Fisheye { k } => grows_until(&k, p.length().atan()),
        };
        (holds && p.is_finite()).then(|| self.distort_unchecked(p))
    }

    /// The ideal position of the distorted position `q`, or `None` where no position
    /// within the limit maps there. Newton on the full model, to 1e-12 relative.
    pub fn undistort(&self, q: DVec2) -> Option<DVec2> {
        if !q.is_finite() {
            return None;
        }
        let mut p = match *self {
            Self::None => return Some(q),
            Self::RadialPixels { centre, k, limit_px } => {
                let v = q - centre;
                centre + v * inverse_scale(&k, v.length(), limit_px)?
            }
            Self::Brown { k, .. } => q * inverse_scale(&k, q.length(), f64::INFINITY)?,
            Self::Fisheye { k } => {
                let theta_d = q.length();
                if theta_d == 0.0 {
                    return Some(q);
                }
                // Strictly inside a half turn: tan must be finite and positive.
                let theta = theta_d * inverse_scale(&k, theta_d, FRAC_PI_2)?;
                q * (theta.tan() / theta_d)
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
                centre + v * scale(&k, v.length_squared())
            }
            Self::Brown { k, p: [p1, p2] } => {
                let r2 = p.length_squared();
                let tangential = DVec2::new(
                    2.0 * p1 * p.x * p.y + p2 * (r2 + 2.0 * p.x * p.x),
                    p1 * (r2 + 2.0 * p.y * p.y) + 2.0 * p2 * p.x * p.y,
                );
                p * scale(&k, r2) + tangential
            }
            Self::Fisheye { k } => {
                let r = p.length();
                if r == 0.0 {
                    return p;
                }
                let theta = r.atan();
                p * (theta * scale(&k, theta * theta) / r)
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

#[cfg(test)]
mod tests;

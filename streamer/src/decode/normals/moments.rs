//! Count, sum and products of points, and the plane that fits them best.

use std::f64::consts::TAU;
use std::ops::AddAssign;

use glam::{DMat3, DVec3};

/// What is kept of a set of points: enough for its mean and covariance. Sets add up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moments {
    count: f64,
    sum: DVec3,
    /// Sums of xx, yy, zz, and of xy, yz, zx.
    squares: DVec3,
    products: DVec3,
}

impl Moments {
    /// Adds a point, metres from an origin that all points share. At 100 m from it, variances
    /// keep 10⁻¹¹ m².
    pub(super) fn include(&mut self, p: DVec3) {
        self.count += 1.0;
        self.sum += p;
        self.squares += p * p;
        self.products += p * DVec3::new(p.y, p.z, p.x);
    }

    /// How many points there are.
    pub(super) fn count(&self) -> f64 {
        self.count
    }

    /// Their mean; NaN where there are none.
    pub(super) fn mean(&self) -> DVec3 {
        self.sum / self.count
    }

    /// The plane of least squared distances: a point on it, the mean, and its unit normal.
    ///
    /// `None` where the variance across it exceeds `flat` times the smaller variance along
    /// it, or that `broad` times the larger.
    pub(super) fn plane(&self, flat: f64, broad: f64) -> Option<(DVec3, DVec3)> {
        let mean = self.mean();
        let covariance = self.covariance();
        let [across, short, long] = eigenvalues(&covariance);
        // Written so that NaN is refused.
        if !(long > 0.0 && short >= broad * long && across <= flat * short) {
            return None;
        }
        Some((mean, eigenvector(&covariance, across)?))
    }

    /// Symmetric; m².
    fn covariance(&self) -> DMat3 {
        let mean = self.mean();
        let v = self.squares / self.count - mean * mean;
        let c = self.products / self.count - mean * DVec3::new(mean.y, mean.z, mean.x);
        DMat3::from_cols_array(&[v.x, c.x, c.z, c.x, v.y, c.y, c.z, c.y, v.z])
    }
}

impl AddAssign for Moments {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.sum += other.sum;
        self.squares += other.squares;
        self.products += other.products;
    }
}

/// Eigenvalues of a symmetric matrix, ascending, to about 10⁻⁸ of the largest.
///
/// The characteristic polynomial of `(A − q I) / p`, with `q` the mean of the eigenvalues and
/// `p` their spread, is `x³ − 3x − 2r`, whose roots are `2 cos(φ + k τ/3)` with `cos 3φ = r`.
fn eigenvalues(a: &DMat3) -> [f64; 3] {
    let q = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let shifted = *a - DMat3::from_diagonal(DVec3::splat(q));
    let squares = [shifted.x_axis, shifted.y_axis, shifted.z_axis].map(DVec3::length_squared);
    let p = (squares.iter().sum::<f64>() / 6.0).sqrt();
    if !(p > 0.0) {
        return [q; 3];
    }
    let r = 0.5 * (shifted * (1.0 / p)).determinant();
    let phi = r.clamp(-1.0, 1.0).acos() / 3.0;
    let largest = q + 2.0 * p * phi.cos();
    let least = q + 2.0 * p * (phi + TAU / 3.0).cos();
    [least, 3.0 * q - largest - least, largest]
}

/// A unit vector `v` with `A v = value v`, for a symmetric matrix and an eigenvalue that is
/// apart from the others. It is normal to the rows of `A − value I`, which span a plane: the
/// longest of their cross products. `None` where they do not.
fn eigenvector(a: &DMat3, value: f64) -> Option<DVec3> {
    let rows = *a - DMat3::from_diagonal(DVec3::splat(value));
    let (x, y, z) = (rows.x_axis, rows.y_axis, rows.z_axis);
    [x.cross(y), y.cross(z), z.cross(x)]
        .into_iter()
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
        .and_then(DVec3::try_normalize)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The symmetric matrix with these eigenvalues, its axes turned by a quaternion.
    fn turned(values: [f64; 3], q: [f64; 4]) -> (DMat3, DMat3) {
        let axes = DMat3::from_quat(glam::DQuat::from_array(q).normalize());
        (axes * DMat3::from_diagonal(DVec3::from_array(values)) * axes.transpose(), axes)
    }

    proptest! {
        /// Eigenvalues from equal to eight orders of magnitude apart.
        #[test]
        fn a_turned_diagonal_comes_back(
            steps in [0.0..8.0f64, 0.0..8.0f64],
            scale in -12.0..3.0f64,
            q in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64],
        ) {
            let long = 10f64.powf(scale);
            let short = long * 10f64.powf(-steps[0]);
            let across = short * 10f64.powf(-steps[1]);
            let (matrix, axes) = turned([across, short, long], q);
            let found = eigenvalues(&matrix);
            for (found, wanted) in found.into_iter().zip([across, short, long]) {
                prop_assert!((found - wanted).abs() <= 3e-8 * long, "{found} {wanted} {long}");
            }
            // Where the two larger ones are comparable the plane is known, and so its normal.
            if across <= 0.15 * short && short >= 0.05 * long {
                let normal = eigenvector(&matrix, found[0]).expect("a plane");
                let sine = normal.cross(axes.x_axis).length();
                prop_assert!(sine < 1e-6, "{sine}");
            }
        }
    }

    #[test]
    fn equal_eigenvalues_have_no_plane() {
        for value in [0.0, 1.0, 1e-300] {
            let matrix = DMat3::from_diagonal(DVec3::splat(value));
            assert_eq!(eigenvalues(&matrix), [value; 3]);
            assert_eq!(eigenvector(&matrix, value), None);
        }
    }

    #[test]
    fn moments_add_up() {
        let points = [DVec3::new(70.0, -3.0, 0.01), DVec3::new(70.1, -3.0, 0.02), DVec3::ONE];
        let (mut all, mut one, mut rest) =
            (Moments::default(), Moments::default(), Moments::default());
        for (i, &p) in points.iter().enumerate() {
            all.include(p);
            if i == 0 { one.include(p) } else { rest.include(p) }
        }
        one += rest;
        assert_eq!(one.count(), 3.0);
        assert!((one.mean() - (points[0] + points[1] + points[2]) / 3.0).length() < 1e-13);
        assert!(
            (one.covariance() - all.covariance()).to_cols_array().iter().all(|c| c.abs() < 1e-11)
        );
    }
}

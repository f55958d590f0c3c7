//! The step of alignment, in f64.
//!
//! Let a and b be what two photographs show at the cells x of a window, each displaced by its
//! share of f; g the gradient of their mean, and d = b - a. To first order a further step s
//! changes d to d + g . s, so that Σ w (d + g . s)² is least where (Σ w g gᵀ) s = -Σ w g d (Lucas
//! and Kanade). To the matrix comes a constant of noise, which keeps s at 0 where there is nothing
//! to see and along edges where only one direction is known. The step is weakened where Σ w d² is
//! no more than resampling explains: what agrees already is left as it is. It is kept within a
//! cell, as far as the first order goes; coarser levels have made the larger ones. All of it is
//! continuous in what the photographs show, so that nothing jumps as the eye moves.

use glam::{DMat2, DVec2};

const NOISE: f64 = 0.015;
const ALIKE: f64 = 0.007;
const LONGEST: f64 = 1.0;

/// The step, cells, of the sums over a window of g gᵀ (its upper half: xx, xy, yy), of g d, and of
/// d².
pub(crate) fn lucas_kanade(ggt: [f64; 3], gd: DVec2, dd: f64) -> DVec2 {
    let [xx, xy, yy] = ggt;
    let matrix = DMat2::from_cols(DVec2::new(xx + NOISE, xy), DVec2::new(xy, yy + NOISE));
    let step = -(matrix.inverse() * gd) * (dd / (dd + ALIKE));
    step.clamp(DVec2::splat(-LONGEST), DVec2::splat(LONGEST))
}

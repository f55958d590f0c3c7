//! Exposure gains, in f64.
//!
//! Each photograph lends places, spread evenly over its depth map. A depth map knows, texel by
//! texel, the nearest mesh at `z_m ± δ_m` and the nearest point at `z_p`. Its surface is the point
//! where `z_p ≤ z_m + δ_m`, else the mesh. A place is taken where the surface a footprint's half to
//! each of four sides lies within 20 % of its depth.
//!
//! Another photograph shows such a place at depth z where its own depth map has a surface at
//! `z_s ± δ_s` with `|z − z_s| ≤ 15 cm + 2 % z + δ_s`, which allows for the inclination of a surface
//! within a texel, for noise, and for discs that stand out of it. Unlike the test that keeps
//! photographs from colouring what is hidden, this one is of both sides: what lies beside the edge
//! of something is then not measured from either side.
//!
//! Of the places that both of two photographs show, `r = ln(b / a)` is the median, channel by
//! channel; its variance that of a median of as many as there are, of values that spread as the
//! channels' means do, and of what no number of places reduces. With `x` the logarithms of the
//! gains, `Σ (x_a − x_b − r_ab)² / σ_ab² + Σ x_a² / σ_0²` is least, once for the mean of the channels
//! and once for what each differs from it by. It is where each x is the weighted mean of what its
//! neighbours want it to be, and of 0.

use super::overlaps::{
    BRIGHTEST, DARKEST, LEAST_PLACES, MEDIAN_VARIANCE, NORMAL_DEVIATION, Overlap, SYSTEMATIC,
};
use super::solve::{COLOUR_DEVIATION, EXPOSURE_DEVIATION, LARGEST_GAIN};
use crate::depth_map::reference::Occluders;
use crate::surface::reference::SAME_SURFACE_M;

/// Width of what is averaged around a place, as a share of its depth.
pub(crate) const FOOTPRINT: f64 = 0.03;
/// Least width, in texels of the photograph, of what is averaged.
pub(crate) const LEAST_TEXELS: f64 = 0.5;
/// How far a place may lie off the surface that a depth map knows there, beside what a surface may
/// be off a mesh, as a share of its depth.
pub(crate) const AGREES_SHARE: f64 = 0.02;
/// Share of its depth by which a surface may recede within what is averaged around a place.
pub(crate) const SAME_SURFACE_SHARE: f64 = 0.2;

/// Depth and uncertainty; `None` where nothing is known.
pub(crate) fn known_surface(texel: Occluders) -> Option<(f64, f64)> {
    let Occluders { mesh_m, mesh_uncertainty_m, point_m } = texel;
    if point_m.is_finite() && point_m <= mesh_m + mesh_uncertainty_m {
        Some((point_m, 0.0))
    } else {
        (mesh_m < crate::mesh::reference::NO_MESH_M).then_some((mesh_m, mesh_uncertainty_m))
    }
}

/// How much nearer z lies than the surface's limits of agreement, metres; negative where it does
/// not agree.
pub(crate) fn agreement(z: f64, (surface_m, uncertainty_m): (f64, f64)) -> f64 {
    SAME_SURFACE_M + AGREES_SHARE * z + uncertainty_m - (z - surface_m).abs()
}

/// The same for whether a surface beside that at z is the same one.
pub(crate) fn continuity(z: f64, beside_m: f64) -> f64 {
    SAME_SURFACE_SHARE * z - (z - beside_m).abs()
}

/// What the linear colours, a's and b's, say that two photographs show of the same places.
pub(crate) fn overlap(a: usize, b: usize, places: &[[[f64; 3]; 2]]) -> Option<Overlap> {
    let usable = |c: &f64| *c >= f64::from(DARKEST) && *c <= f64::from(BRIGHTEST);
    let ratios: Vec<[f64; 3]> = places
        .iter()
        .filter(|both| both.as_flattened().iter().all(usable))
        .map(|[a, b]| [0, 1, 2].map(|channel| (b[channel] / a[channel]).ln()))
        .collect();
    if ratios.len() < LEAST_PLACES {
        return None;
    }
    let log_ratio = [0, 1, 2].map(|channel| median(ratios.iter().map(|r| r[channel]).collect()));
    let means: Vec<f64> = ratios.iter().map(|r| r.iter().sum::<f64>() / 3.0).collect();
    let middle = median(means.clone());
    let spread = NORMAL_DEVIATION * median(means.iter().map(|m| (m - middle).abs()).collect());
    let random = MEDIAN_VARIANCE * spread * spread / ratios.len() as f64;
    Some(Overlap { a, b, log_ratio, variance: SYSTEMATIC * SYSTEMATIC + random })
}

/// The logarithms of the gains of `count` photographs.
pub(crate) fn solved(count: usize, overlaps: &[Overlap]) -> Vec<[f64; 3]> {
    let mean = |o: &Overlap| o.log_ratio.iter().sum::<f64>() / 3.0;
    let exposures = balanced(count, overlaps, EXPOSURE_DEVIATION, mean);
    let tints = [0, 1, 2]
        .map(|c| balanced(count, overlaps, COLOUR_DEVIATION, |o| o.log_ratio[c] - mean(o)));
    let most = LARGEST_GAIN.ln();
    (0..count)
        .map(|i| [0, 1, 2].map(|c| (exposures[i] + tints[c][i]).min(most).max(-most)))
        .collect()
}

/// Goes to the weighted means, one photograph after the other, until none moves.
fn balanced(
    count: usize,
    overlaps: &[Overlap],
    deviation: f64,
    ratio: impl Fn(&Overlap) -> f64,
) -> Vec<f64> {
    let mut x = vec![0.0; count];
    for _ in 0..100_000 {
        let mut moved = 0.0f64;
        for i in 0..count {
            let (mut wanted, mut weights) = (0.0, 1.0 / (deviation * deviation));
            for o in overlaps {
                let wants = match i {
                    i if i == o.a => x[o.b] + ratio(o),
                    i if i == o.b => x[o.a] - ratio(o),
                    _ => continue,
                };
                wanted += wants / o.variance;
                weights += 1.0 / o.variance;
            }
            moved = moved.max((wanted / weights - x[i]).abs());
            x[i] = wanted / weights;
        }
        if moved < 1e-12 {
            break;
        }
    }
    x
}

/// The lower one of the two in the middle.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(values.len() - 1) / 2]
}

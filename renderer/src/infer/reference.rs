//! The passes over the grid, in f64.
//!
//! Diffusion is push and pull (Gortler et al., The Lumigraph). A level gives each of its cells a
//! value v and a weight w of 0 to 1. A cell of the next coarser level covers the cells c, and has
//! v' = Σ w v / Σ w and w' = min(Σ w, 1); the device keeps w v, which needs no division where w
//! is 0. Back from the coarsest, whose lack is the backdrop, a level is made whole by what the
//! coarser one has there: w v + (1 - w) u, where u interpolates the coarser level between the
//! centres of its cells, and is constant beyond the outermost.
//!
//! A hypothesis costs what the brightness differs by that the nearest two rigs show which see it,
//! at most a bound; a constant where fewer see it. Costs are averaged over the square of cells that
//! reaches R to all sides, as far as it lies on the grid.
//!
//! Hypothesis i of a cell has the inverse range h(i) = b + (d - b) i / n, with b that of the
//! backdrop, d the diffused one and n its index. It is judged by what the photographs disagree on
//! it, and by what is expected: cost(i) + P min(2 |1 - i / n|, 1) - K max(1 - m / |h(1) - h(0)|, 0).
//! The second term is a prior for the diffused depth, which reaches half way to the backdrop. In
//! the third m is how far the inverse range of the hypothesis, as the picture before this one saw
//! it, is from what was settled there. The lowest wins, and where it has two neighbours, the lowest
//! point of the parabola through the three, within half a step. What settles is the hypothesis of
//! the median of a cell and its eight neighbours, which the border repeats.

use flaneur_scene::PosedCamera;
use glam::{DVec3, UVec2};

use crate::reference::field::{Field, cells};

pub(crate) const WORST: f64 = 0.12;
pub(crate) const UNSEEN: f64 = 0.08;
pub(crate) const REACH: u32 = 5;
pub(crate) const PRIOR: f64 = 0.004;
pub(crate) const KEPT: f64 = 0.004;

/// A value with its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known {
    pub(crate) value: f64,
    pub(crate) weight: f64,
}

/// The inverse range of every cell, 1/m, from that of the cells where it is known.
pub(crate) fn diffused(known: &Field<Known>, backdrop: f64) -> Field<f64> {
    let coarser = if known.size == UVec2::ONE {
        Field { size: UVec2::ONE, values: vec![backdrop] }
    } else {
        diffused(&pulled(known), backdrop)
    };
    // The last level takes what it has: some knowledge is all there is.
    let alone = known.size == UVec2::ONE;
    Field::new(known.size, |cell| {
        let Known { value, weight } = known.at(cell);
        let weight = if alone && weight > 0.0 { 1.0 } else { weight };
        weight * value + (1.0 - weight) * coarser.between((cell.as_dvec2() + 0.5) / 2.0)
    })
}

/// What a hypothesis costs that rigs see as so bright, the nearest first, `None` where one does
/// not.
pub(crate) fn disagreement(seen: impl IntoIterator<Item = Option<f64>>) -> f64 {
    let mut seen = seen.into_iter().flatten();
    match (seen.next(), seen.next()) {
        (Some(first), Some(second)) => (first - second).abs().min(WORST),
        _ => UNSEEN,
    }
}

/// The mean of the costs of one hypothesis around a cell.
pub(crate) fn window(costs: &Field<f64>, cell: UVec2) -> f64 {
    let near = |other: &UVec2| other.as_ivec2().chebyshev_distance(cell.as_ivec2()) <= REACH;
    let near: Vec<f64> = cells(costs.size).filter(near).map(|other| costs.at(other)).collect();
    near.iter().sum::<f64>() / near.len() as f64
}

/// Inverse range, 1/m, of a hypothesis.
pub(crate) fn hypothesis(index: f64, diffused_index: u32, backdrop: f64, diffused: f64) -> f64 {
    backdrop + (diffused - backdrop) * index / f64::from(diffused_index)
}

/// What a hypothesis costs, of which the photographs say `cost` and the picture before `kept`.
pub(crate) fn judged(cost: f64, index: u32, diffused_index: u32, kept: f64) -> f64 {
    let far = (1.0 - f64::from(index) / f64::from(diffused_index)).abs();
    cost + PRIOR * (2.0 * far).min(1.0) - kept
}

/// Which hypothesis wins, of what each is judged.
pub(crate) fn chosen(judged: &[f64]) -> f64 {
    let best = (0..judged.len()).min_by(|&a, &b| judged[a].total_cmp(&judged[b])).unwrap_or(0);
    if best == 0 || best + 1 == judged.len() {
        return best as f64;
    }
    // y = here + slope x + bend x².
    let slope = 0.5 * (judged[best + 1] - judged[best - 1]);
    let bend = 0.5 * (judged[best + 1] + judged[best - 1]) - judged[best];
    let lowest = if bend > 0.0 { -slope / (2.0 * bend) } else { 0.0 };
    best as f64 + lowest.clamp(-0.5, 0.5)
}

/// The picture before, and what settled there.
#[derive(Clone, Debug)]
pub(crate) struct Past {
    pub(crate) camera: PosedCamera,
    /// Pixels a side of a cell.
    pub(crate) step: f64,
    /// Inverse ranges, 1/m.
    pub(crate) settled: Field<f64>,
}

impl Past {
    /// What it says for a place in the world whose cell has hypotheses `spacing` apart, 1/m.
    pub(crate) fn kept(&self, place: DVec3, spacing: f64) -> f64 {
        let pixel = self.camera.project(place).map(|(pixel, _)| pixel);
        let Some(pixel) = pixel.filter(|&pixel| self.camera.lens.contains(pixel)) else {
            return 0.0;
        };
        let settled = self.settled.at((pixel / self.step).as_uvec2());
        let missed = (settled - 1.0 / self.camera.centre.distance(place)).abs();
        KEPT * (1.0 - missed / spacing).max(0.0)
    }
}

/// The median of a cell and those around it.
pub(crate) fn median(chosen: &Field<f64>, cell: UVec2) -> f64 {
    let last = chosen.size - 1;
    let mut around: Vec<f64> = cells(UVec2::splat(3))
        .map(|offset| chosen.at((cell + offset).saturating_sub(UVec2::ONE).min(last)))
        .collect();
    around.sort_by(f64::total_cmp);
    around[4]
}

/// The next coarser level.
fn pulled(finer: &Field<Known>) -> Field<Known> {
    let size = (finer.size + 1) / 2;
    Field::new(size, |cell| {
        let covered = cells(finer.size).filter(|&other| other / 2 == cell);
        let (sum, weight) = covered
            .map(|other| finer.at(other))
            .fold((0.0, 0.0), |(s, w), k| (s + k.weight * k.value, w + k.weight));
        let value = if weight > 0.0 { sum / weight } else { 0.0 };
        Known { value, weight: weight.min(1.0) }
    })
}

//! The passes over the grid, in f64.
//!
//! Of each cell 4 × 4 pixels are looked at, evenly spread. The mean of their directions, made unit, is
//! the cell's; the share of them that shows geometry decides whether it is judged: half and more is
//! known enough. The mean of that geometry's inverse ranges, if there is any, is what is known.
//!
//! From there it is diffused, see diffuse/reference.rs; without any geometry all is backdrop.
//!
//! At the place of a hypothesis a rig shows what its brightness there exceeds the mean of four places
//! in its picture by, REACH cells aside to the corners, two levels of detail coarser: exposure
//! cancels, patterns stay. A hypothesis costs what that differs by that the nearest two rigs show which see it,
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
//! the median of a cell and its eight neighbours, which the border repeats. A pixel without geometry
//! is at the inverse range between those of the four cells around it.

use flaneur_scene::PosedCamera;
use glam::{DVec3, UVec2};

use crate::diffuse::reference::{Known, mean};
use crate::reference::field::{Field, cells};

/// Cells from a place to the corners of its surroundings.
pub(crate) const AROUND: f64 = 3.0;
/// Of these, texels are so many times as wide.
pub(crate) const COARSER: f64 = 4.0;
/// Pixels a side that are looked at in each cell.
pub(crate) const SAMPLES: u32 = 4;
/// No place is farther, 1/m.
pub(crate) const LEAST_INVERSE: f64 = 1e-9;
pub(crate) const WORST: f64 = 0.12;
pub(crate) const UNSEEN: f64 = 0.08;
pub(crate) const REACH: u32 = 5;
pub(crate) const PRIOR: f64 = 0.01;
pub(crate) const KEPT: f64 = 0.004;

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Looked {
    /// Unit, from the eye.
    pub(crate) direction: DVec3,
    /// Of geometry, metres.
    pub(crate) range_m: Option<f64>,
}

/// What a cell shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gathered {
    /// Unit, from the eye; zero where the lens sees nothing.
    pub(crate) direction: DVec3,
    /// Share that is geometry.
    pub(crate) share: f64,
    /// Inverse range, 1/m, with weight 1; weight 0 without any.
    pub(crate) known: Known<f64>,
}

/// Which pixels are looked at of a cell of `step` pixels a side.
pub(crate) fn looked_at(picture: UVec2, step: u32, cell: UVec2) -> impl Iterator<Item = UVec2> {
    let stride = step / SAMPLES;
    let pixels = cells(UVec2::splat(SAMPLES)).map(move |i| cell * step + i * stride + stride / 2);
    pixels.filter(move |pixel| pixel.cmplt(picture).all())
}

/// What a cell of `step` pixels a side shows of a picture, whose lens sees nothing where there is
/// `None`.
pub(crate) fn gathered(picture: &Field<Option<Looked>>, step: u32, cell: UVec2) -> Gathered {
    let pixels = looked_at(picture.size, step, cell);
    let looked: Vec<Looked> = pixels.filter_map(|pixel| picture.at(pixel)).collect();
    let inverses: Vec<f64> = looked.iter().filter_map(|l| Some(1.0 / l.range_m?)).collect();
    Gathered {
        direction: looked.iter().map(|l| l.direction).sum::<DVec3>().normalize_or_zero(),
        share: inverses.len() as f64 / looked.len().max(1) as f64,
        known: mean(&inverses),
    }
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

/// The least and the greatest that [`chosen`] may be where any two differ by up to `noise` more or
/// less.
pub(crate) fn chosen_between(judged: &[f64], noise: f64) -> [f64; 2] {
    let lowest = judged.iter().copied().fold(f64::INFINITY, f64::min);
    let near = (0..judged.len()).filter(|&i| judged[i] <= lowest + noise);
    let reached = near.flat_map(|i| {
        let best = i as f64;
        if i == 0 || i + 1 == judged.len() {
            return [best, best];
        }
        let slope = 0.5 * (judged[i + 1] - judged[i - 1]);
        let bend = 0.5 * (judged[i + 1] + judged[i - 1]) - judged[i];
        // Any bend that is left, and none.
        let turns = [-0.5, 0.5].map(|off| slope + off * noise).map(|slope| {
            let bends = [bend - noise, bend + noise].map(|bend| bend.max(f64::MIN_POSITIVE));
            bends.map(|bend| (-slope / (2.0 * bend)).clamp(-0.5, 0.5))
        });
        let turns = turns.as_flattened().iter().copied();
        let flat = if bend <= noise { 0.0 } else { turns.clone().fold(0.5, f64::min) };
        let low = turns.clone().fold(flat, f64::min);
        [best + low, best + turns.fold(flat, f64::max)]
    });
    reached.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
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

//! How two photographs are made to agree, in f64.
//!
//! On each level of a pyramid of grids both photographs say how bright they show the cells; a cell
//! that one does not see has no value. A photograph's pattern is what its brightness differs by from
//! its mean over the cells around that both see. The displacement f that is known from the coarser
//! level, of which the first photograph takes the share s, is undone: the first pattern is looked up
//! at x - s f, the second at x + (1 - s) f, both between the centres of cells, and only where all
//! that has a part there is seen.
//!
//! Let a and b be what the two show at the cells x of a window, each displaced by its share of f; g
//! the gradient of their mean, by central differences, and d = b - a. To first order a further step
//! s changes d to d + g . s, so that Σ w (d + g . s)² is least where (Σ w g gᵀ) s = -Σ w g d (Lucas
//! and Kanade). Cells that differ by more than noise have smaller weights w = 1 / (1 + (d / δ)²):
//! there one shows something else. To the matrix comes a constant of noise, which keeps s at 0 where
//! there is nothing to see and along edges where only one direction is known. The step is weakened
//! by s²/(s² + α²), where s = Σ w d² is no more than what photographs of one place differ by, resampled, noisy and
//! taken in another light: what agrees already is left as it is. It is kept within a cell, as far as the first
//! order goes; coarser levels have made the larger ones. All of it is continuous in what the photographs
//! show, so that nothing jumps as the eye moves.
//!
//! Last, each cell takes the mean of the displacements around, by binomial weights and by how much
//! there is to see, the trace of Σ w g gᵀ.

use glam::{DMat2, DVec2, DVec3, IVec2, UVec2};

use crate::reference::field::{Field, cells, shares};

pub(crate) const NOISE: f64 = 0.015;
/// Over the 49 cells of a window: nearly a twentieth of full brightness, root mean square.
pub(crate) const ALIKE: f64 = 0.1;
pub(crate) const LONGEST: f64 = 1.0;
/// The δ beyond which cells show something else.
pub(crate) const OTHER: f64 = 0.1;
/// Of what a pattern stands out, cells to all sides.
pub(crate) const AROUND: u32 = 4;
/// Of the sums for one step, cells to all sides.
pub(crate) const WINDOW: u32 = 3;
/// What is weighed even where there is nothing to see.
const LEAST_TRACE: f64 = 1e-6;
/// Share of what has a part in a place that both must see.
const SEEN: f64 = 0.99;

/// What two photographs show of the cells of a level, brightness; `None` where one does not see.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    /// Pixels a side of a cell.
    pub(crate) step: f64,
    pub(crate) sights: [Field<Option<f64>>; 2],
}

/// The displacement, pixels, from what the first photograph shows of each cell of the finest level
/// to what the second shows. `levels` are finest first; `share` is the first photograph's.
pub(crate) fn displacements(levels: &[Level], share: f64) -> Field<DVec2> {
    let mut known: Option<(Field<DVec2>, f64)> = None;
    for level in levels.iter().rev() {
        let size = level.sights[0].size;
        let before = Field::new(size, |cell| {
            let pixel = (cell.as_dvec2() + 0.5) * level.step;
            known.as_ref().map_or(DVec2::ZERO, |(field, step)| field.between(pixel / step))
        });
        known = Some((refined(level, &before, share), level.step));
    }
    known.map_or(Field { size: UVec2::ZERO, values: Vec::new() }, |(field, _)| field)
}

/// The step, cells, of the sums over a window of g gᵀ (its upper half: xx, xy, yy), of g d, and of
/// d².
pub(crate) fn lucas_kanade(ggt: [f64; 3], gd: DVec2, dd: f64) -> DVec2 {
    let [xx, xy, yy] = ggt;
    let matrix = DMat2::from_cols(DVec2::new(xx + NOISE, xy), DVec2::new(xy, yy + NOISE));
    let step = -(matrix.inverse() * gd) * (dd.powi(2) / (dd.powi(2) + ALIKE.powi(2)));
    step.clamp(DVec2::splat(-LONGEST), DVec2::splat(LONGEST))
}

/// What one cell adds to the sums.
#[derive(Clone, Copy, Debug, Default)]
struct Products {
    ggt: DVec3,
    gd: DVec2,
    dd: f64,
}

fn refined(level: &Level, before: &Field<DVec2>, share: f64) -> Field<DVec2> {
    let size = before.size;
    let patterns = patterns(&level.sights);
    let pair = Field::new(size, |cell| {
        let (centre, moved) = (cell.as_dvec2() + 0.5, before.at(cell) / level.step);
        let first = looked_up(&patterns, centre - share * moved)?;
        let second = looked_up(&patterns, centre + (1.0 - share) * moved)?;
        Some(DVec2::new(first.x, second.y))
    });
    let products = Field::new(size, |cell| products(&pair, cell).unwrap_or_default());
    let solved = Field::new(size, |cell| {
        let sum = around(size, cell, WINDOW).map(|other| products.at(other)).fold(
            Products::default(),
            |a, b| Products { ggt: a.ggt + b.ggt, gd: a.gd + b.gd, dd: a.dd + b.dd },
        );
        let step = lucas_kanade(sum.ggt.to_array(), sum.gd, sum.dd);
        (before.at(cell) + level.step * step, sum.ggt.x + sum.ggt.z + LEAST_TRACE)
    });
    Field::new(size, |cell| {
        let (mut sum, mut weights) = (DVec2::ZERO, 0.0);
        for offset in (-1..=1).flat_map(|y| (-1..=1).map(move |x| IVec2::new(x, y))) {
            let (displacement, trace) = solved.at(nearest(size, cell.as_ivec2() + offset));
            let binomial = [1.0, 2.0, 1.0];
            let weight =
                trace * binomial[(offset.x + 1) as usize] * binomial[(offset.y + 1) as usize];
            sum += displacement * weight;
            weights += weight;
        }
        sum / weights
    })
}

/// By how much both stand out of what is around, where both see the cell.
fn patterns([first, second]: &[Field<Option<f64>>; 2]) -> Field<Option<DVec2>> {
    let both = Field::new(first.size, |cell| Some(DVec2::new(first.at(cell)?, second.at(cell)?)));
    Field::new(first.size, |cell| {
        let near: Vec<DVec2> =
            around(first.size, cell, AROUND).filter_map(|other| both.at(other)).collect();
        Some(both.at(cell)? - near.iter().sum::<DVec2>() / near.len() as f64)
    })
}

/// Both patterns at a place, in cells.
fn looked_up(patterns: &Field<Option<DVec2>>, place: DVec2) -> Option<DVec2> {
    let (mut sum, mut seen) = (DVec2::ZERO, 0.0);
    for (cell, share) in shares(patterns.size, place) {
        if let Some(pattern) = patterns.at(cell) {
            sum += pattern * share;
            seen += share;
        }
    }
    (seen > SEEN).then_some(sum)
}

fn products(pair: &Field<Option<DVec2>>, cell: UVec2) -> Option<Products> {
    let here = pair.at(cell)?;
    let beside = |x: i32, y: i32| pair.at(nearest(pair.size, cell.as_ivec2() + IVec2::new(x, y)));
    let mean = |both: DVec2| 0.5 * (both.x + both.y);
    let g = 0.5
        * DVec2::new(
            mean(beside(1, 0)?) - mean(beside(-1, 0)?),
            mean(beside(0, 1)?) - mean(beside(0, -1)?),
        );
    let d = here.y - here.x;
    let weight = 1.0 / (1.0 + (d / OTHER).powi(2));
    Some(Products {
        ggt: weight * DVec3::new(g.x * g.x, g.x * g.y, g.y * g.y),
        gd: weight * d * g,
        dd: weight * d * d,
    })
}

/// The cells that lie within `reach` of one to all sides.
fn around(size: UVec2, cell: UVec2, reach: u32) -> impl Iterator<Item = UVec2> {
    let low = cell.saturating_sub(UVec2::splat(reach));
    let high = (cell + reach).min(size - 1);
    cells(high - low + 1).map(move |offset| low + offset)
}

fn nearest(size: UVec2, cell: IVec2) -> UVec2 {
    cell.clamp(IVec2::ZERO, size.as_ivec2() - 1).as_uvec2()
}

//! The passes over the grid, in f64.
//!
//! Diffusion is push and pull (Gortler et al., The Lumigraph). A level gives each of its cells a
//! value v and a weight w of 0 to 1. A cell of the next coarser level covers the cells c, and has
//! v' = Σ w v / Σ w and w' = min(Σ w, 1); the device keeps w v, which needs no division where w
//! is 0. Back from the coarsest, whose lack is the backdrop, a level is made whole by what the
//! coarser one has there: w v + (1 - w) u, where u interpolates the coarser level between the
//! centres of its cells, and is constant beyond the outermost.

use glam::{DVec2, UVec2};

/// Values of the cells of a grid, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field<T> {
    pub(crate) size: UVec2,
    pub(crate) values: Vec<T>,
}

impl<T: Copy> Field<T> {
    pub(crate) fn new(size: UVec2, value: impl FnMut(UVec2) -> T) -> Self {
        Self { size, values: cells(size).map(value).collect() }
    }

    pub(crate) fn at(&self, cell: UVec2) -> T {
        self.values[(cell.y * self.size.x + cell.x) as usize]
    }
}

/// A value with its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known {
    pub(crate) value: f64,
    pub(crate) weight: f64,
}

pub(crate) fn cells(size: UVec2) -> impl Iterator<Item = UVec2> {
    (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec2::new(x, y)))
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
        weight * value + (1.0 - weight) * between(&coarser, (cell.as_dvec2() + 0.5) / 2.0)
    })
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

/// The field at a place, in cells from the first one's corner.
fn between(field: &Field<f64>, place: DVec2) -> f64 {
    let place = place.clamp(DVec2::splat(0.5), field.size.as_dvec2() - 0.5);
    cells(field.size)
        .map(|cell| {
            let share = 1.0 - (place - (cell.as_dvec2() + 0.5)).abs().min(DVec2::ONE);
            share.element_product() * field.at(cell)
        })
        .sum()
}

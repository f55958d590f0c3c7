//! Values over grids, for the references of passes over grids.

use std::ops::{Add, Mul};

use glam::{DVec2, UVec2};

/// Values of the cells of a grid, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field<T> {
    pub(crate) size: UVec2,
    pub(crate) values: Vec<T>,
}

impl<T> Field<T> {
    /// The same grid with what each value gives.
    pub(crate) fn each<U>(&self, value: impl FnMut(&T) -> U) -> Field<U> {
        Field { size: self.size, values: self.values.iter().map(value).collect() }
    }
}

impl<T: Copy> Field<T> {
    pub(crate) fn new(size: UVec2, value: impl FnMut(UVec2) -> T) -> Self {
        Self { size, values: cells(size).map(value).collect() }
    }

    /// The value of a cell, which must be one of them.
    pub(crate) fn at(&self, cell: UVec2) -> T {
        self.values[(cell.y * self.size.x + cell.x) as usize]
    }
}

impl<T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>> Field<T> {
    /// The value at a place, in cells from the first one's corner: between the centres of four
    /// cells, and constant beyond the outermost.
    pub(crate) fn between(&self, place: DVec2) -> T {
        shares(self.size, place)
            .fold(T::default(), |sum, (cell, share)| sum + self.at(cell) * share)
    }
}

/// The cells around a place, with what each counts between them.
pub(crate) fn shares(size: UVec2, place: DVec2) -> impl Iterator<Item = (UVec2, f64)> {
    let place = place.clamp(DVec2::splat(0.5), size.as_dvec2() - 0.5) - 0.5;
    let first = place.floor();
    [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().filter_map(move |step| {
        let cell = first.as_uvec2() + UVec2::from(step);
        let share = 1.0 - (cell.as_dvec2() - place).abs();
        // Beyond the last one nothing counts.
        cell.cmplt(size).all().then(|| (cell, share.element_product()))
    })
}

/// All cells of a grid, row by row.
pub(crate) fn cells(size: UVec2) -> impl Iterator<Item = UVec2> {
    (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec2::new(x, y)))
}

//! Colours for what is inferred, or ground, and has none, in f64.
//!
//! Of each cell of a grid 4 × 4 pixels are looked at, evenly spread; the mean linear colour of those that are
//! inferred and coloured is the cell's, with weight 1, if there are any. It is diffused over all cells, see
//! diffuse/reference.rs. An inferred pixel without a colour has the one between those of the four cells
//! around it. The same once more, apart, for the ground.

use crate::diffuse::reference::{Known, Value, diffused, mean};
use crate::infer::Grid;
use crate::infer::reference::looked_at;
use crate::reference::field::Field;

/// The colour of every cell, linear, from those of the pixels that are of the kind and coloured;
/// `None` where there are none.
pub(crate) fn completed<T: Value>(picture: &Field<Option<T>>, grid: Grid) -> Option<Field<T>> {
    let known: Field<Known<T>> = Field::new(grid.cells, |cell| {
        let pixels = looked_at(picture.size, grid.step, cell);
        mean(&pixels.filter_map(|pixel| picture.at(pixel)).collect::<Vec<T>>())
    });
    let any = known.values.iter().any(|known| known.weight > 0.0);
    any.then(|| diffused(&known, T::default()))
}

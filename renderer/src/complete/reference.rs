//! Colours for what is inferred, or ground, and has none, in f64.
//!
//! Of each cell of a grid 4 × 4 pixels are looked at, evenly spread; the mean linear colour of those that are
//! inferred and coloured is the cell's, with weight 1, if there are any. It is diffused over all cells, see
//! diffuse/reference.rs. An inferred pixel without a colour has the one between those of the four cells
//! around it. The same once more, apart, for the ground.
//!
//! For points the colours of all surfaces are gathered likewise, but go to the cells beside alone, with a weight w
//! that falls there (`near` of diffuse/reference.rs): what no photograph sees of them has w times that colour, and
//! 1 - w times its own.

use crate::diffuse::reference::{Known, Value, diffused, mean, near};
use crate::infer::Grid;
use crate::infer::reference::looked_at;
use crate::reference::field::Field;

/// The colour of every cell, linear, from those of the pixels that are of the kind and coloured;
/// `None` where there are none.
pub(crate) fn completed<T: Value>(picture: &Field<Option<T>>, grid: Grid) -> Option<Field<T>> {
    let known = gathered(picture, grid);
    let any = known.values.iter().any(|known| known.weight > 0.0);
    any.then(|| diffused(&known, T::default()))
}

/// What the cells beside coloured pixels of a kind take of their colours: those, linear, times a weight, and
/// that.
pub(crate) fn beside<T: Value>(picture: &Field<Option<T>>, grid: Grid) -> (Field<T>, Field<f64>) {
    near(&gathered(picture, grid))
}

fn gathered<T: Value>(picture: &Field<Option<T>>, grid: Grid) -> Field<Known<T>> {
    Field::new(grid.cells, |cell| {
        let pixels = looked_at(picture.size, grid.step, cell);
        mean(&pixels.filter_map(|pixel| picture.at(pixel)).collect::<Vec<T>>())
    })
}

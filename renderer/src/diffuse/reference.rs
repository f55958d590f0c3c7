//! Push and pull, in f64.
//!
//! A level gives each of its cells a value v and a weight w of 0 to 1. A cell of the next coarser
//! level covers the cells c, and has v' = Σ w v / Σ w and w' = min(Σ w, 1); the device keeps w v,
//! which needs no division where w is 0. Back from the coarsest, which takes a given value if it has none,
//! a level is made whole by what the coarser one has there: w v + (1 - w) u, where u interpolates
//! the coarser level between the centres of its cells, and is constant beyond the outermost.
//!
//! What is to stay near goes up two levels only, and is left as it is there: u is w' v', and the same is done
//! with the weights, so that they tell how much of a cell is known.

use std::ops::{Add, Mul};

use glam::UVec2;

use crate::reference::field::{Field, cells};

/// How many levels up goes what is to stay near: it comes as far as one to three times the cells of the
/// last.
pub(crate) const NEAR_LEVELS: usize = 2;

/// What values can be averaged.
pub(crate) trait Value:
    Copy + Default + Add<Output = Self> + Mul<f64, Output = Self>
{
}

impl<T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>> Value for T {}

/// A value with its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known<T> {
    pub(crate) value: T,
    pub(crate) weight: f64,
}

/// The mean of what is known of a cell, weight 1; weight 0 where that is nothing.
pub(crate) fn mean<T: Value>(values: &[T]) -> Known<T> {
    let sum = values.iter().fold(T::default(), |sum, &value| sum + value);
    let value = sum * (1.0 / values.len().max(1) as f64);
    Known { value, weight: if values.is_empty() { 0.0 } else { 1.0 } }
}

/// The value of every cell, from that of the cells where it is known.
pub(crate) fn diffused<T: Value>(known: &Field<Known<T>>, otherwise: T) -> Field<T> {
    let coarser = if known.size == UVec2::ONE {
        Field { size: UVec2::ONE, values: vec![otherwise] }
    } else {
        diffused(&pulled(known), otherwise)
    };
    // The last level takes what it has: some knowledge is all there is.
    let alone = known.size == UVec2::ONE;
    Field::new(known.size, |cell| {
        let Known { value, weight } = known.at(cell);
        let weight = if alone && weight > 0.0 { 1.0 } else { weight };
        value * weight + coarser.between((cell.as_dvec2() + 0.5) / 2.0) * (1.0 - weight)
    })
}

/// What is known of every cell and, with less weight, of those near it: times its weight, and that. What a
/// cell lacks of a weight of 1 it takes from the next coarser level, as far as that has it.
pub(crate) fn near<T: Value>(known: &Field<Known<T>>) -> (Field<T>, Field<f64>) {
    up_to(known, NEAR_LEVELS)
}

fn up_to<T: Value>(known: &Field<Known<T>>, levels: usize) -> (Field<T>, Field<f64>) {
    if levels == 0 {
        return (known.each(|known| known.value * known.weight), known.each(|known| known.weight));
    }
    let (values, weights) = up_to(&pulled(known), levels - 1);
    let there = |cell: UVec2| (cell.as_dvec2() + 0.5) / 2.0;
    let spread = Field::new(known.size, |cell| {
        let Known { value, weight } = known.at(cell);
        value * weight + values.between(there(cell)) * (1.0 - weight)
    });
    let weights = Field::new(known.size, |cell| {
        let weight = known.at(cell).weight;
        weight + weights.between(there(cell)) * (1.0 - weight)
    });
    (spread, weights)
}

/// The next coarser level.
fn pulled<T: Value>(finer: &Field<Known<T>>) -> Field<Known<T>> {
    let size = (finer.size + 1) / 2;
    Field::new(size, |cell| {
        let covered = cells(finer.size).filter(|&other| other / 2 == cell);
        let (sum, weight) = covered
            .map(|other| finer.at(other))
            .fold((T::default(), 0.0), |(s, w), k| (s + k.value * k.weight, w + k.weight));
        let value = if weight > 0.0 { sum * (1.0 / weight) } else { T::default() };
        Known { value, weight: weight.min(1.0) }
    })
}

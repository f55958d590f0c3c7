//! Continuing known heights into the gaps between them.

use super::REACH_M;
use crate::layers::ground::GroundGrid;

/// Gives a height to every unknown node within about [`REACH_M`] of a known one; known ones
/// stay as they are.
///
/// Pull and push: known heights are averaged into ever coarser grids, and unknown nodes take
/// the bilinear value of the next coarser grid, so that a gap is filled from its whole rim with
/// a surface as smooth as the gap is wide. Linear in the number of nodes.
pub(super) fn fill(grid: &mut GroundGrid) {
    let mut levels = vec![Level {
        columns: grid.columns as usize,
        rows: grid.rows as usize,
        heights: std::mem::take(&mut grid.heights),
    }];
    let mut spacing_m = grid.spacing_m;
    while spacing_m < REACH_M
        && let Some(coarsest) = levels.last()
        && coarsest.columns.max(coarsest.rows) > 1
        && coarsest.heights.iter().any(|height| height.is_nan())
    {
        let coarser = coarsest.coarser();
        levels.push(coarser);
        spacing_m *= 2.0;
    }
    while let Some(coarser) = levels.pop() {
        match levels.last_mut() {
            Some(finer) => finer.fill_from(&coarser),
            None => grid.heights = coarser.heights,
        }
    }
}

struct Level {
    columns: usize,
    rows: usize,
    heights: Vec<f32>,
}

impl Level {
    /// Node (i, j) of the coarser level stands for nodes 2i, 2i + 1 and 2j, 2j + 1 of this one.
    fn coarser(&self) -> Self {
        let (columns, rows) = (self.columns.div_ceil(2), self.rows.div_ceil(2));
        let mut heights = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let (mut sum, mut count) = (0.0, 0u8);
                for r in 2 * row..self.rows.min(2 * row + 2) {
                    for c in 2 * column..self.columns.min(2 * column + 2) {
                        let height = self.heights[r * self.columns + c];
                        if !height.is_nan() {
                            sum += f64::from(height);
                            count += 1;
                        }
                    }
                }
                heights.push(if count > 0 { (sum / f64::from(count)) as f32 } else { f32::NAN });
            }
        }
        Self { columns, rows, heights }
    }

    fn fill_from(&mut self, coarser: &Self) {
        for row in 0..self.rows {
            for column in 0..self.columns {
                let height = &mut self.heights[row * self.columns + column];
                if height.is_nan() {
                    *height = coarser.at_finer(column, row);
                }
            }
        }
    }

    /// The value at a node of the next finer level, bilinear among the nodes that are known.
    fn at_finer(&self, column: usize, row: usize) -> f32 {
        // A coarse node lies in the middle of its four: a finer one is a quarter off.
        let near = |fine: usize, count: usize| {
            let coarse = fine / 2;
            let other =
                if fine.is_multiple_of(2) { coarse.checked_sub(1) } else { Some(coarse + 1) };
            (coarse, other.filter(|other| *other < count))
        };
        let (column, next_column) = near(column, self.columns);
        let (row, next_row) = near(row, self.rows);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (c, by_column) in [(Some(column), 0.75), (next_column, 0.25)] {
            for (r, by_row) in [(Some(row), 0.75), (next_row, 0.25)] {
                if let (Some(c), Some(r)) = (c, r)
                    && let height = f64::from(self.heights[r * self.columns + c])
                    && !height.is_nan()
                {
                    sum += by_column * by_row * height;
                    weights += by_column * by_row;
                }
            }
        }
        if weights > 0.0 { (sum / weights) as f32 } else { f32::NAN }
    }
}

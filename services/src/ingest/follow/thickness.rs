//! How thick the surfaces of points are: what is measured of one wall from several places makes a thick
//! wall where the places are wrong, and a thin one where they are right.

use std::collections::HashMap;
use std::path::Path;

use flaneur_scene::Station;
use glam::{DMat3, DVec3};

use crate::ingest::points::{ScannedPoints, scan_timed};
use crate::ingest::{IngestError, Job};

/// Side of the cells in which surfaces are taken for flat, metres.
const CELL_M: f64 = 0.5;
/// Points of a cell that tell how thick it is.
const FEWEST: u32 = 12;
/// They must come from stations as far apart as this, metres.
const APART_M: f64 = 4.0;
/// Cells, at most.
const MOST_CELLS: usize = 1 << 19;
/// What moves by less (metres) is as thick as before.
const LEAST_MOTION_M: f64 = 0.01;

/// Cells of the points as delivered, and as their stations' corrections have them.
#[derive(Default)]
pub(super) struct Thickness([HashMap<[i32; 3], Cell>; 2]);

/// Moments of the points of a cell.
#[derive(Clone, Copy)]
struct Cell {
    count: u32,
    sum: DVec3,
    /// Of the products.
    products: DMat3,
    first_from: DVec3,
    from_elsewhere: bool,
}

impl Thickness {
    /// Of the points in `file`, by the station that is nearest in time.
    pub(super) fn of(
        job: &Job,
        file: &Path,
        delivered: &[Station],
        corrected: &[Station],
    ) -> Result<Self, IngestError> {
        let turns: Vec<DMat3> = corrected.iter().map(|s| s.correction.turn()).collect();
        let mut all = Self::default();
        let mut origin = None;
        scan_timed(&[file.to_owned()], job, |chunk: &ScannedPoints| {
            for (place, time_s) in chunk.positions.iter().zip(&chunk.times_s) {
                let after = delivered.partition_point(|s| s.time_s < *time_s);
                let near = |i: &usize| {
                    delivered.get(*i).map_or(f64::INFINITY, |s| (s.time_s - time_s).abs())
                };
                let candidates = [after.saturating_sub(1), after];
                let Some(index) = candidates.into_iter().min_by(|a, b| near(a).total_cmp(&near(b)))
                else {
                    continue;
                };
                let (Some(station), Some(turn)) = (corrected.get(index), turns.get(index)) else {
                    continue;
                };
                let arm = *place - station.position;
                let moved = *turn * arm + station.position + station.correction.shift_m;
                if moved.distance(*place) < LEAST_MOTION_M {
                    continue;
                }
                let origin = *origin.get_or_insert(*place);
                all.add(0, *place - origin, station.position);
                all.add(1, moved - origin, station.position);
            }
            Ok(())
        })?;
        Ok(all)
    }

    fn add(&mut self, which: usize, place: DVec3, from: DVec3) {
        let key = (place / CELL_M).floor();
        let cells = &mut self.0[which];
        let key = [key.x as i32, key.y as i32, key.z as i32];
        if cells.len() >= MOST_CELLS && !cells.contains_key(&key) {
            return;
        }
        let cell = cells.entry(key).or_insert(Cell {
            count: 0,
            sum: DVec3::ZERO,
            products: DMat3::ZERO,
            first_from: from,
            from_elsewhere: false,
        });
        cell.count += 1;
        cell.sum += place;
        cell.products += DMat3::from_cols(place * place.x, place * place.y, place * place.z);
        cell.from_elsewhere |= from.distance(cell.first_from) >= APART_M;
    }

    /// The median thickness, a standard deviation, before and after, metres; 0 where no cell tells.
    pub(super) fn medians_m(&self) -> [f64; 2] {
        [0, 1].map(|which| {
            let tell = |cell: &&Cell| cell.count >= FEWEST && cell.from_elsewhere;
            let mut all: Vec<f64> =
                self.0[which].values().filter(tell).map(Cell::thickness_m).collect();
            let middle = all.len() / 2;
            if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(middle, f64::total_cmp).1 }
        })
    }
}

impl Cell {
    /// The standard deviation along the direction in which it is least.
    fn thickness_m(&self) -> f64 {
        let count = f64::from(self.count);
        let mean = self.sum / count;
        let outer = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
        least_eigenvalue(&(self.products * (1.0 / count) - outer)).max(0.0).sqrt()
    }
}

/// Of a symmetric matrix (Smith, 1961: "Eigenvalues of a symmetric 3 × 3 matrix").
fn least_eigenvalue(a: &DMat3) -> f64 {
    let mean = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let b = *a - DMat3::from_diagonal(DVec3::splat(mean));
    let squares = b.x_axis.length_squared() + b.y_axis.length_squared() + b.z_axis.length_squared();
    let p = (squares / 6.0).sqrt();
    if !(p > 0.0) {
        return mean;
    }
    let half = (b * (1.0 / p)).determinant() / 2.0;
    let angle = half.clamp(-1.0, 1.0).acos() / 3.0;
    mean + 2.0 * p * (angle + 2.0 * std::f64::consts::PI / 3.0).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_eigenvalue_is_found() {
        let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(-1.1);
        for values in [DVec3::new(3.0, 0.5, 7.0), DVec3::new(1e-6, 2.0, 2.0), DVec3::splat(4.0)] {
            let matrix = turn * DMat3::from_diagonal(values) * turn.transpose();
            let least = values.min_element();
            assert!((least_eigenvalue(&matrix) - least).abs() < 1e-9, "{values}");
        }
    }
}

//! How far apart the points of a node really are.

use std::collections::HashSet;

use glam::Vec3;

use super::order::{along_a_curve, reordered};

/// Points a cell, on average, at which the cells are counted: enough that few cells of a
/// surface are missed, few enough that a cell holds one surface.
const POINTS_PER_CELL: usize = 8;
/// Points that share a spacing: a patch of a surface of 16 by 16.
const RUN_POINTS: usize = 256;
/// How many times as close as its level says the points of a leaf may be told to be.
const DENSER: f32 = 8.0;

/// The typical distance between neighbours among `positions`, metres, at least `least_m`.
///
/// The octree's level only bounds the distance from below: a leaf holds what the scanner gave,
/// which may be much sparser. Points are taken to lie on surfaces: where n points touch k
/// cubes of edge c, the surface is about k c² large, so that its points are c √(k / n) apart.
/// The cubes are doubled from `least_m` until they hold eight points each, which is where
/// the estimate no longer depends on them; for a square grid of points it is within a fifth.
pub(super) fn typical_spacing_m(positions: &[[f32; 3]], least_m: f32) -> f32 {
    let count = positions.len();
    if count < POINTS_PER_CELL || !(least_m > 0.0) {
        return least_m;
    }
    let mut cell_m = 2.0 * least_m;
    let mut cells = HashSet::with_capacity(count);
    loop {
        cells.clear();
        cells.extend(positions.iter().map(|&p| (Vec3::from_array(p) / cell_m).floor().as_ivec3()));
        if cells.len() * POINTS_PER_CELL <= count {
            return (cell_m * (cells.len() as f32 / count as f32).sqrt()).max(least_m);
        }
        cell_m *= 2.0;
        // All of space within a node fits eight cubes long before this is reached.
        if !cell_m.is_finite() {
            return least_m;
        }
    }
}

/// The typical distance between neighbours around each of `positions`, metres: that of the run of
/// points along a curve through space that it belongs to.
///
/// The points of one node are dense beside the scanner and thin at its reach, and those of a leaf
/// may be denser than its level says, which is `level_m`. Cubes at the borders of a run hold few
/// points, so that the distance is found too large by a third to a half: nothing opens.
pub(super) fn spacings_m(positions: &[[f32; 3]], level_m: f32) -> Vec<f32> {
    let mut spacings_m = vec![level_m; positions.len()];
    for run in along_a_curve(positions, &[]).chunks(RUN_POINTS) {
        let spacing_m = typical_spacing_m(&reordered(positions, run), level_m / DENSER);
        for &index in run {
            if let Some(of_point) = spacings_m.get_mut(index as usize) {
                *of_point = spacing_m;
            }
        }
    }
    spacings_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall of points `spacing_m` apart, inclined to the axes.
    fn wall(side: u16, spacing_m: f32) -> Vec<[f32; 3]> {
        let (right, up) = (Vec3::new(0.8, 0.6, 0.0), Vec3::new(-0.06, 0.08, 0.995));
        let at = |i: u16| f32::from(i) * spacing_m;
        (0..side)
            .flat_map(|i| (0..side).map(move |j| (right * at(i) + up * at(j)).to_array()))
            .collect()
    }

    #[test]
    fn the_spacing_of_a_wall_is_found_whatever_the_level_says() {
        for spacing_m in [0.02, 0.05, 0.13, 0.4] {
            for least_m in [0.005, 0.011, 0.02] {
                let found = typical_spacing_m(&wall(100, spacing_m), least_m);
                assert!((found / spacing_m - 1.0).abs() < 0.35, "{spacing_m} {least_m}: {found}");
            }
        }
    }

    /// A node whose two halves are unlike: each has its own spacing, but where they meet.
    #[test]
    fn spacings_follow_the_points() {
        let mut positions = wall(64, 0.03);
        positions.extend(wall(64, 0.12).iter().map(|p| [p[0] + 20.0, p[1], p[2]]));
        let found = spacings_m(&positions, 0.05);
        assert_eq!(found.len(), positions.len());
        // A run that holds some of both is as thin as its thinner half.
        let shares = positions.iter().zip(&found).filter_map(|(p, spacing_m)| {
            let (near, far) = (spacing_m / 0.03, spacing_m / 0.12);
            let share = if p[0] < 10.0 { near } else { far };
            (share < 2.5).then_some(share)
        });
        let shares: Vec<f32> = shares.collect();
        assert!(shares.len() >= positions.len() - RUN_POINTS, "{} of all", shares.len());
        assert!(shares.iter().all(|share| (0.9..2.0).contains(share)), "{shares:?}");
    }

    #[test]
    fn few_points_or_equal_ones_have_the_spacing_of_their_level() {
        assert_eq!(typical_spacing_m(&[[1.0; 3]; 3], 0.1), 0.1);
        assert_eq!(typical_spacing_m(&vec![[1.0; 3]; 5000], 0.1), 0.1);
        assert_eq!(typical_spacing_m(&[], 0.1), 0.1);
    }
}

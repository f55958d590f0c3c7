//! Normals of points, from the surface that their neighbours lie on.
//!
//! Points are gathered in cubes, of which only count, sum and products are kept. Around each
//! cube's mean a tree finds the others that are near; their moments together give a plane, and
//! the points of the cube that lie on it take its normal. So many points in one place cost no
//! more than one, and a chunk costs what its surface needs.

use std::collections::HashMap;

use glam::{DVec3, IVec3, Vec3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

mod moments;

use moments::Moments;

/// Edge of a cube, spacings: it holds about four points of a surface.
const EDGE: f32 = 2.0;
/// Least edge of a cube, metres. Drives of the same street lie a decimetre apart however dense
/// they are, and within less than a few of them no orientation can be seen.
const LEAST_EDGE_M: f32 = 0.2;
/// How far from a cube's mean others still count, edges.
const REACH: f32 = 2.0;
/// Fewest points that make a surface.
const FEWEST: f64 = 5.0;
/// Largest variance across a plane, as a share of the smaller one along it. The edge where two
/// walls meet at a right angle has 0.28; noise may reach a third of a cube's edge.
const FLAT: f64 = 0.15;
/// Smallest variance along a plane, as a share of the larger one: points of a cable, or of
/// one line of a scanner, lie on every plane through it.
const BROAD: f64 = 0.05;
/// How far off the plane a point may lie that takes its normal, edges.
const OFF_PLANE: f64 = 0.5;

/// A unit normal a point, of either sign; zero where the neighbours of a point are no surface.
///
/// Positions are in metres, `spacing_m` is the typical distance between neighbours. The same
/// positions in the same order always give the same normals. Empty where the spacing is no
/// positive number.
pub(super) fn normals(positions: &[[f32; 3]], spacing_m: f32) -> Vec<[f32; 3]> {
    if !(spacing_m > 0.0 && spacing_m.is_finite()) {
        return Vec::new();
    }
    let edge_m = (EDGE * spacing_m).max(LEAST_EDGE_M);
    let (cells, cell_of) = cells(positions, edge_m);
    let means: Vec<[f32; 3]> = cells.iter().map(|cell| cell.mean().as_vec3().to_array()).collect();
    // It fails only where more cubes are given than a u32 can name.
    let Ok(tree) = ImmutableKdTree::<f32, 3>::new_from_slice(&means) else { return Vec::new() };
    let reach_2 = (REACH * edge_m).powi(2);
    let planes: Vec<Option<(DVec3, DVec3)>> = means
        .iter()
        .map(|mean| {
            let mut around = Moments::default();
            tree.query(mean)
                .within::<SquaredEuclidean<f32>>(reach_2)
                .unsorted()
                .visit(|found| around += cells[found.item as usize]);
            (around.count() >= FEWEST).then(|| around.plane(FLAT, BROAD)).flatten()
        })
        .collect();
    let tolerance_m = OFF_PLANE * f64::from(edge_m);
    positions
        .iter()
        .zip(cell_of)
        .map(|(&position, cell)| match planes[cell as usize] {
            Some((through, normal)) => {
                let off = normal.dot(Vec3::from_array(position).as_dvec3() - through);
                if off.abs() <= tolerance_m { normal.as_vec3().to_array() } else { [0.0; 3] }
            }
            None => [0.0; 3],
        })
        .collect()
}

/// The occupied cubes in the order of their first points, and the cube of each point.
fn cells(positions: &[[f32; 3]], edge_m: f32) -> (Vec<Moments>, Vec<u32>) {
    let mut number_of: HashMap<IVec3, u32> = HashMap::with_capacity(positions.len());
    let mut cells: Vec<Moments> = Vec::new();
    let cell_of = positions
        .iter()
        .map(|&position| {
            let position = Vec3::from_array(position);
            let cube = (position / edge_m).floor().as_ivec3();
            let number = *number_of.entry(cube).or_insert(cells.len() as u32);
            if number as usize == cells.len() {
                cells.push(Moments::default());
            }
            cells[number as usize].include(position.as_dvec3());
            number
        })
        .collect();
    (cells, cell_of)
}

#[cfg(test)]
mod tests;

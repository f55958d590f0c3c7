//! Where a ray meets a tile of mesh.
//!
//! Triangles lie in a grid over the plan: a street's surfaces stand upright or lie flat, so that a ray meets
//! few cells, and few triangles in each.

use std::sync::Arc;

use flaneur_scene::{Bounds3, MeshTile, Ray};
use glam::{DVec2, DVec3, IVec2, UVec2, Vec3};

/// Least edge of a cell, metres.
const CELL_M: f64 = 4.0;
/// Most cells along an edge of a tile.
const MOST_CELLS: f64 = 64.0;
/// A triangle is in no more cells than this on average: where it would be, cells are larger.
const MOST_ENTRIES: usize = 16;

/// A tile of mesh.
#[derive(Debug)]
pub(super) struct Surface {
    mesh: Arc<MeshTile>,
    bounds: Bounds3,
    cell_m: f64,
    size: UVec2,
    /// Where the triangles of each cell begin, and where those of the last end.
    starts: Vec<u32>,
    /// First of the three indices of each.
    triangles: Vec<u32>,
}

impl Surface {
    /// `None` where it has no triangle.
    pub(super) fn of(mesh: &Arc<MeshTile>) -> Option<Self> {
        let mut bounds = Bounds3::EMPTY;
        let corners: Vec<(u32, [DVec3; 3])> = (0..mesh.indices.len() / 3)
            .filter_map(|index| Some((3 * index as u32, corners(mesh, 3 * index)?)))
            .collect();
        corners.iter().flat_map(|(_, three)| three).for_each(|&p| bounds.include(p));
        if corners.is_empty() {
            return None;
        }
        let extent = (bounds.max - bounds.min).truncate();
        let mut cell_m = (extent.max_element() / MOST_CELLS).max(CELL_M);
        let entries = |cell_m: f64| -> usize {
            let of_one = |(_, three): &(u32, [DVec3; 3])| {
                let (from, to) = covered(three, bounds.min, cell_m);
                ((to - from + 1).element_product()) as usize
            };
            corners.iter().map(of_one).sum()
        };
        while entries(cell_m) > MOST_ENTRIES * corners.len() && cell_m < extent.max_element() {
            cell_m *= 2.0;
        }
        let size = (extent / cell_m).as_uvec2() + 1;
        let mut of_cells: Vec<Vec<u32>> = vec![Vec::new(); (size.x * size.y) as usize];
        for (first, three) in &corners {
            for cell in cells(three, bounds.min, cell_m) {
                of_cells[index(cell, size)].push(*first);
            }
        }
        let mut starts = vec![0];
        for of_cell in &of_cells {
            starts.push(starts.last().unwrap_or(&0) + of_cell.len() as u32);
        }
        let (mesh, triangles) = (Arc::clone(mesh), of_cells.concat());
        Some(Self { mesh, bounds, cell_m, size, starts, triangles })
    }

    /// The depth at which a ray comes into its box, `None` where it does not.
    pub(super) fn entered(&self, ray: &Ray) -> Option<f64> {
        within(&self.bounds, &self.local(ray)).map(|(from, _)| from)
    }

    /// The depth at which a ray first meets it, if that is less than `most`.
    pub(super) fn meets(&self, ray: &Ray, most: f64) -> Option<f64> {
        let ray = self.local(ray);
        let (from, to) = within(&self.bounds, &ray)?;
        let (origin, way) = (ray.origin.truncate(), ray.direction.truncate());
        let low = self.bounds.min.truncate();
        let at = (origin + way * from - low) / self.cell_m;
        let last = self.size.as_ivec2() - 1;
        let mut cell = at.floor().as_ivec2().clamp(IVec2::ZERO, last);
        let step = way.signum().as_ivec2();
        // The depths at which the ray leaves the cell along x and along y.
        let border = |cell: IVec2| low + (cell + step.max(IVec2::ZERO)).as_dvec2() * self.cell_m;
        let leaves = |cell: IVec2| {
            let depths = (border(cell) - origin) / way;
            // Along an axis a ray may not move at all.
            DVec2::select(way.abs().cmpgt(DVec2::splat(1e-12)), depths, DVec2::INFINITY)
        };
        let mut nearest = most;
        loop {
            let left = leaves(cell);
            for &first in self.of_cell(cell) {
                let depth = corners(&self.mesh, first as usize)
                    .and_then(|three| meets_triangle(&ray, &three))
                    .unwrap_or(f64::INFINITY);
                nearest = nearest.min(depth);
            }
            if nearest <= left.min_element() || left.min_element() >= to {
                break;
            }
            if left.x <= left.y {
                cell.x += step.x;
            } else {
                cell.y += step.y;
            }
            if cell.cmplt(IVec2::ZERO).any() || cell.cmpgt(last).any() {
                break;
            }
        }
        (nearest < most).then_some(nearest)
    }

    fn of_cell(&self, cell: IVec2) -> &[u32] {
        let index = index(cell, self.size);
        &self.triangles[self.starts[index] as usize..self.starts[index + 1] as usize]
    }

    /// A ray relative to the tile's origin.
    fn local(&self, ray: &Ray) -> Ray {
        Ray { origin: ray.origin - self.mesh.origin, direction: ray.direction }
    }
}

/// Where a ray is within a box: from which depth to which, both ≥ 0.
pub(super) fn within(bounds: &Bounds3, ray: &Ray) -> Option<(f64, f64)> {
    let (mut from, mut to) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let (origin, way) = (ray.origin[axis], ray.direction[axis]);
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        if way == 0.0 {
            if !(low..=high).contains(&origin) {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - origin) / way, (high - origin) / way);
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    (from <= to).then_some((from, to))
}

/// The depth at which a ray meets a triangle, on either side (Möller and Trumbore, 1997).
fn meets_triangle(ray: &Ray, [a, b, c]: &[DVec3; 3]) -> Option<f64> {
    let (along_b, along_c) = (b - a, c - a);
    let p = ray.direction.cross(along_c);
    let determinant = along_b.dot(p);
    let from_a = ray.origin - a;
    let q = from_a.cross(along_b);
    let (u, v) = (from_a.dot(p) / determinant, ray.direction.dot(q) / determinant);
    let depth = along_c.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && depth >= 0.0).then_some(depth)
}

/// The corners of the triangle whose first index is at `first`, relative to the tile's origin; `None`
/// where they are not finite.
fn corners(mesh: &MeshTile, first: usize) -> Option<[DVec3; 3]> {
    let corner = |offset: usize| {
        let vertex = mesh.vertices.get(*mesh.indices.get(first + offset)? as usize)?;
        let position = Vec3::from_array(vertex.position);
        position.is_finite().then_some(position.as_dvec3())
    };
    Some([corner(0)?, corner(1)?, corner(2)?])
}

/// The lowest and the highest of the cells that the box of a triangle meets.
fn covered(three: &[DVec3; 3], low: DVec3, cell_m: f64) -> (IVec2, IVec2) {
    let [a, b, c] = three.map(|corner| (corner - low).truncate() / cell_m);
    (a.min(b).min(c).as_ivec2(), a.max(b).max(c).as_ivec2())
}

fn cells(three: &[DVec3; 3], low: DVec3, cell_m: f64) -> impl Iterator<Item = IVec2> {
    let (from, to) = covered(three, low, cell_m);
    (from.y..=to.y).flat_map(move |y| (from.x..=to.x).map(move |x| IVec2::new(x, y)))
}

fn index(cell: IVec2, size: UVec2) -> usize {
    cell.y as usize * size.x as usize + cell.x as usize
}

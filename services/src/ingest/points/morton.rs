//! The octree's cells in Morton order (Z-order): points of a cell of any level are
//! neighbours in a list sorted by code, and a node's children follow one another.

use flaneur_scene::{NodeKey, OctreeCube};
use glam::{DVec3, IVec3};

/// Bits of an axis in a code.
pub(super) const CODE_BITS: u32 = 21;

/// Levels that are told apart: 2³² cells along an edge, a micrometre in four kilometres.
pub(super) const CELL_LEVELS: u32 = 32;

/// A cube, with its raw coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) cube: OctreeCube,
    scale: DVec3,
    offset: DVec3,
    min: DVec3,
    cells_per_m: f64,
}

impl Grid {
    /// The smallest cube around raw coordinates from `min` to `max`. Its spacing is left for
    /// the tree to choose.
    pub(super) fn around(min: IVec3, max: IVec3, scale: DVec3, offset: DVec3) -> Self {
        let low = min.as_dvec3() * scale + offset;
        let high = max.as_dvec3() * scale + offset;
        // A single point gets a cube as well, and rounding stays inside the margin.
        let edge = (high - low).max_element() + scale.max_element();
        let centre = low.midpoint(high);
        let half_size_m = edge / 2.0;
        let cube = OctreeCube { centre, half_size_m, spacing_m: edge };
        Self {
            cube,
            scale,
            offset,
            min: centre - half_size_m,
            cells_per_m: f64::from(CELL_LEVELS).exp2() / edge,
        }
    }

    /// Sets the spacing that sampling with 2^`grid_bits` cells along a node's edge gives.
    pub(super) fn set_spacing(&mut self, grid_bits: u32) {
        self.cube.spacing_m = 2.0 * self.cube.half_size_m / f64::from(grid_bits).exp2();
    }

    /// The cell of the finest level that a point lies in.
    pub(super) fn cell(&self, raw: IVec3) -> [u32; 3] {
        let cell = (raw.as_dvec3() * self.scale + self.offset - self.min) * self.cells_per_m;
        // `as` stops at the cube's faces.
        cell.to_array().map(|axis| axis as u32)
    }
}

/// The Morton code of [`CODE_BITS`] levels of a cell, from level `base` down, x in the
/// lowest bit. `base` is at most `CELL_LEVELS - CODE_BITS`.
pub(super) fn code(cell: [u32; 3], base: u32) -> u64 {
    let shift = CELL_LEVELS - CODE_BITS - base;
    let [x, y, z] = cell.map(|axis| spread(axis >> shift));
    x | y << 1 | z << 2
}

/// The node of a level that a cell lies in.
pub(super) fn node_at(cell: [u32; 3], level: u32) -> NodeKey {
    let [x, y, z] = cell.map(|axis| axis.checked_shr(CELL_LEVELS - level).unwrap_or(0));
    NodeKey { level, x, y, z }
}

/// The place of a cell in Morton order among those `depth` levels below its node at `level`.
/// `level + depth` is at most [`CELL_LEVELS`], `depth` at most [`CODE_BITS`].
pub(super) fn cell_in_node(cell: [u32; 3], level: u32, depth: u32) -> usize {
    let shift = CELL_LEVELS - level - depth;
    let [x, y, z] = cell.map(|axis| spread(axis >> shift & ((1 << depth) - 1)));
    (x | y << 1 | z << 2) as usize
}

/// How far the centre of the cell that `bits` levels subdivide is from the sub-cell `code`,
/// in an arbitrary unit.
pub(super) fn distance_to_centre(code: u64, bits: u32) -> u64 {
    let centre = (1i64 << bits) - 1;
    [code, code >> 1, code >> 2]
        .map(|axis| (2 * i64::from(gather(axis)) - centre).pow(2).unsigned_abs())
        .iter()
        .sum()
}

/// Moves bit `i` of the lowest 21 to bit `3i`.
fn spread(axis: u32) -> u64 {
    let mut x = u64::from(axis) & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Moves bit `3i` to bit `i`: the x axis of a code, or another axis of a shifted one.
pub(super) fn gather(code: u64) -> u32 {
    let mut x = code & 0x1249_2492_4924_9249;
    x = (x | x >> 2) & 0x10c3_0c30_c30c_30c3;
    x = (x | x >> 4) & 0x100f_00f0_0f00_f00f;
    x = (x | x >> 8) & 0x001f_0000_ff00_00ff;
    x = (x | x >> 16) & 0x001f_0000_0000_ffff;
    x = (x | x >> 32) & 0x1f_ffff;
    x as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn gathering_undoes_spreading(x in 0u32..1 << 21, y in 0u32..1 << 21, z in 0u32..1 << 21) {
            let code = code([x << 11, y << 11, z << 11], 0);
            prop_assert_eq!([gather(code), gather(code >> 1), gather(code >> 2)], [x, y, z]);
        }

        /// The node named by a code's leading bits is the one whose box holds the point,
        /// to a rounding of 1e-9 of the cube.
        #[test]
        fn points_lie_in_their_nodes(
            raw in [any::<i32>(), any::<i32>(), any::<i32>()],
            a in [any::<i32>(), any::<i32>(), any::<i32>()],
            level in 0u32..=25,
        ) {
            let (raw, a) = (IVec3::from(raw), IVec3::from(a));
            let (scale, offset) = (DVec3::new(1e-3, 1e-3, 1e-2), DVec3::new(6e5, 6.8e6, 0.0));
            let grid = Grid::around(raw.min(a), raw.max(a), scale, offset);
            let bounds = grid.cube.node_bounds(node_at(grid.cell(raw), level));
            let point = raw.as_dvec3() * scale + offset;
            let slack = 1e-9 * grid.cube.half_size_m + 1e-8;
            prop_assert!(bounds.distance(point) <= slack, "{point} outside {bounds:?}");
        }
    }

    #[test]
    fn the_middle_is_nearer_the_centre_than_a_corner() {
        let middle = code([1 << 31; 3], 0) & 0x3f;
        assert!(distance_to_centre(0b111, 2) < distance_to_centre(middle, 2));
    }
}

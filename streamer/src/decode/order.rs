//! The order in which a chunk's points are handed on.

use glam::{UVec3, Vec3};

/// Cells along each axis of a chunk's box, between which order matters.
const CELLS: f32 = 1024.0;

/// The indices of `positions` so that points near each other in space come near each other:
/// along a Z-order curve through their box, equal cells as they were. A renderer can then leave
/// out runs of points that a view does not see, and draws runs of equally large ones.
///
/// Where there are `runs`, a number a point, those of the lowest number come first, each run along
/// a curve of its own.
pub(super) fn along_a_curve(positions: &[[f32; 3]], runs: &[u16]) -> Vec<u32> {
    let (min, max) = positions
        .iter()
        .map(|&p| Vec3::from_array(p))
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
    let scale = CELLS / (max - min).max_element().max(f32::MIN_POSITIVE);
    let mut keyed: Vec<(u16, u32, u32)> = positions
        .iter()
        .zip(0..)
        .map(|(&p, index)| {
            let run = runs.get(index as usize).copied().unwrap_or_default();
            (run, code(((Vec3::from_array(p) - min) * scale).as_uvec3()), index)
        })
        .collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, _, index)| index).collect()
}

/// `values` in the order of `indices`; those that are out of range are left out.
pub(super) fn reordered<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().filter_map(|&index| values.get(index as usize).copied()).collect()
}

/// Interleaves the bits of a cell's coordinates.
fn code(cell: UVec3) -> u32 {
    let cell = cell.min(UVec3::splat(CELLS as u32 - 1));
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}

/// Puts two zeros after each of the lowest ten bits.
fn spread(bits: u32) -> u32 {
    let mut x = bits;
    x = (x | x << 16) & 0x0300_00ff;
    x = (x | x << 8) & 0x0300_f00f;
    x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_interleaved() {
        for bits in [0, 1, 0b10_1101_0011, 1023] {
            let expected = (0..10).fold(0, |code, bit| code | (bits >> bit & 1) << (3 * bit));
            assert_eq!(spread(bits), expected, "{bits:b}");
        }
        assert_eq!(code(UVec3::new(1, 2, 4)), 0b100_010_001);
        assert_eq!(code(UVec3::splat(5000)), (1 << 30) - 1);
    }

    /// On a square, runs of 256 points are a few times 16 x 16 instead of anywhere.
    #[test]
    fn runs_of_points_are_small() {
        let positions: Vec<[f32; 3]> = (0..10_000u32)
            .map(|i| {
                let i = i * 7919 % 10_000;
                [(i % 100) as f32, (i / 100) as f32, 0.0]
            })
            .collect();
        let order = along_a_curve(&positions, &[]);
        let ordered = reordered(&positions, &order);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..10_000), "every point once");
        let areas = ordered.chunks(256).map(|run| {
            let side = |axis: usize| {
                let values = run.iter().map(|p| p[axis]);
                values.clone().fold(0.0, f32::max) - values.fold(f32::INFINITY, f32::min)
            };
            side(0) * side(1)
        });
        let mean = areas.sum::<f32>() / 40.0;
        assert!(mean < 1200.0, "{mean} of 10000");
    }

    #[test]
    fn few_or_equal_points_keep_their_order() {
        assert!(along_a_curve(&[], &[]).is_empty());
        assert_eq!(along_a_curve(&[[3.0; 3]; 4], &[]), [0, 1, 2, 3]);
        assert_eq!(along_a_curve(&[[3.0; 3]; 4], &[1, 0, 1, 0]), [1, 3, 0, 2]);
    }
}

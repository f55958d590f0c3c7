//! Dividing points that do not fit in memory into buckets that do: nodes of the octree,
//! found by counting points in a grid of cells seven levels below a node.

use std::sync::atomic::{AtomicU64, Ordering};

use flaneur_scene::NodeKey;

use super::morton::{CELL_LEVELS, cell_in_node, gather};

/// Levels of the grid below its node: 2²¹ cells, 16 MiB of counters.
const DEPTH: u32 = 7;

/// Points counted by cell, cells in Morton order.
pub(super) struct CountGrid {
    node: NodeKey,
    cells: Vec<AtomicU64>,
}

/// A node that is sorted on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bucket {
    pub(super) key: NodeKey,
    pub(super) points: u64,
}

/// Which points go where.
pub(super) struct Plan {
    node: NodeKey,
    /// Without empty ones, in Morton order.
    pub(super) buckets: Vec<Bucket>,
    bucket_of_cell: Vec<u32>,
}

impl CountGrid {
    /// No points yet below `node`, which is at most at level 25.
    pub(super) fn new(node: NodeKey) -> Self {
        let mut cells = Vec::new();
        cells.resize_with(1 << (3 * DEPTH), AtomicU64::default);
        Self { node, cells }
    }

    /// Counts a point of the node.
    pub(super) fn count(&self, cell: [u32; 3]) {
        self.cells[cell_in_node(cell, self.node.level, DEPTH)].fetch_add(1, Ordering::Relaxed);
    }

    /// Cells of the grid with 2^`bits` along an edge that hold points.
    pub(super) fn occupied(&self, bits: u32) -> usize {
        self.cells
            .chunks(1 << (3 * (DEPTH - bits)))
            .filter(|cells| cells.iter().any(|cell| cell.load(Ordering::Relaxed) > 0))
            .count()
    }

    /// Buckets of at most `capacity` points, as large as that allows; but none deeper than
    /// `deepest` or the grid, whatever it holds.
    pub(super) fn plan(self, capacity: u64, deepest: u32) -> Plan {
        let counts: Vec<u64> = self.cells.into_iter().map(AtomicU64::into_inner).collect();
        let mut plan = Plan {
            node: self.node,
            buckets: Vec::new(),
            bucket_of_cell: vec![u32::MAX; counts.len()],
        };
        let depth = DEPTH.min(deepest.saturating_sub(self.node.level));
        plan.divide(&counts, 0, 0, depth, capacity);
        plan
    }
}

impl Plan {
    /// The bucket of a point, an index; `None` where no point was counted.
    pub(super) fn bucket_of(&self, cell: [u32; 3]) -> Option<usize> {
        let bucket = self.bucket_of_cell[cell_in_node(cell, self.node.level, DEPTH)];
        (bucket != u32::MAX).then_some(bucket as usize)
    }

    /// Divides `counts`, the cells of the `number`-th node at `depth`.
    fn divide(&mut self, counts: &[u64], number: u64, depth: u32, most: u32, capacity: u64) {
        let points: u64 = counts.iter().sum();
        if points == 0 {
            return;
        }
        if points > capacity && depth < most {
            for (child, counts) in (8 * number..).zip(counts.chunks(counts.len() / 8)) {
                self.divide(counts, child, depth + 1, most, capacity);
            }
            return;
        }
        let axis = |root: u32, shift: u32| (root << depth) + gather(number >> shift);
        let key = NodeKey {
            level: self.node.level + depth,
            x: axis(self.node.x, 0),
            y: axis(self.node.y, 1),
            z: axis(self.node.z, 2),
        };
        let first_cell = number as usize * counts.len();
        self.bucket_of_cell[first_cell..first_cell + counts.len()].fill(self.buckets.len() as u32);
        self.buckets.push(Bucket { key, points });
    }
}

const _: () = assert!(CELL_LEVELS - DEPTH == 25, "grids reach the finest cells");

#[cfg(test)]
mod tests {
    use super::super::morton::node_at;
    use super::*;

    #[test]
    fn buckets_hold_what_was_counted_and_nothing_too_large() {
        let grid = CountGrid::new(NodeKey::ROOT);
        // A diagonal, and a cluster too dense for any bucket.
        let points: Vec<[u32; 3]> = (0..5_000u32)
            .map(|i| [i * 800_000; 3])
            .chain((0..500).map(|_| [u32::MAX; 3]))
            .collect();
        for point in &points {
            grid.count(*point);
        }
        assert_eq!(grid.occupied(1), 2);
        let plan = grid.plan(100, 25);
        let mut found = vec![0; plan.buckets.len()];
        for point in &points {
            let bucket = plan.bucket_of(*point).unwrap();
            assert_eq!(node_at(*point, plan.buckets[bucket].key.level), plan.buckets[bucket].key);
            found[bucket] += 1;
        }
        for (bucket, found) in plan.buckets.iter().zip(found) {
            assert_eq!(bucket.points, found);
            assert!(found <= 100 || bucket.key.level == 7, "{bucket:?}");
        }
    }
}

//! Connected patches of ground.

use crate::layers::ground::GroundGrid;

/// Nodes this far apart along rows or columns may belong together, metres.
const GAP_M: f64 = 2.0;

/// A patch smaller than this, square metres, is no ground: an echo from below, a wall or a roof
/// of which nothing around is seen.
const LEAST_AREA_M2: f64 = 50.0;

/// Nor is one smaller than this share of the largest.
const LEAST_SHARE: f64 = 0.05;

/// Drops the nodes that a walk over the ground does not reach: neighbours belong together where
/// their heights differ by no more than `slope` × distance + `step_m`, and patches that are small
/// are dropped.
pub(super) fn drop_small_patches(grid: &mut GroundGrid, slope: f64, step_m: f64) {
    let (columns, rows) = (grid.columns as usize, grid.rows as usize);
    let reach = (GAP_M / grid.spacing_m).ceil() as usize;
    let mut patches = Patches { parents: (0..grid.heights.len() as u32).collect() };
    for row in 0..rows {
        for column in 0..columns {
            let node = row * columns + column;
            let height = grid.heights[node];
            if height.is_nan() {
                continue;
            }
            // Each pair once: what lies east in this row, and everything in rows to the north.
            for r in row..rows.min(row + reach + 1) {
                let first = if r == row { column + 1 } else { column.saturating_sub(reach) };
                for c in first..columns.min(column + reach + 1) {
                    let other = r * columns + c;
                    let nodes_apart = ((r - row) as f64).hypot(c as f64 - column as f64);
                    let allowed = slope * nodes_apart * grid.spacing_m + step_m;
                    // A comparison with NaN is false.
                    if f64::from((grid.heights[other] - height).abs()) <= allowed {
                        patches.join(node as u32, other as u32);
                    }
                }
            }
        }
    }
    let mut sizes = vec![0u32; grid.heights.len()];
    for node in 0..grid.heights.len() {
        if !grid.heights[node].is_nan() {
            sizes[patches.root(node as u32) as usize] += 1;
        }
    }
    let largest = f64::from(sizes.iter().copied().max().unwrap_or(0));
    let least = (LEAST_AREA_M2 / grid.spacing_m.powi(2)).max(LEAST_SHARE * largest).min(largest);
    for node in 0..grid.heights.len() {
        if f64::from(sizes[patches.root(node as u32) as usize]) < least {
            grid.heights[node] = f32::NAN;
        }
    }
}

/// Disjoint sets of nodes, by path halving.
struct Patches {
    parents: Vec<u32>,
}

impl Patches {
    fn root(&mut self, mut node: u32) -> u32 {
        loop {
            let parent = self.parents[node as usize];
            if parent == node {
                return node;
            }
            self.parents[node as usize] = self.parents[parent as usize];
            node = parent;
        }
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // Towards the smaller number: sets stay shallow as nodes are visited in order.
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

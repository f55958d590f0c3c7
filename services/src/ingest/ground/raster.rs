//! Dense heights averaged around the nodes of a grid.

use glam::DVec3;

use super::fill::fill;
use super::frame::Frame;
use crate::ingest::Job;
use crate::layers::ground::{GroundGrid, MAX_NODES};

/// Bytes that a node costs while a mean is taken and filled.
const NODE_BYTES: u64 = 32;

/// The nodes that fit into a quarter of the memory budget.
pub(super) fn most_nodes(job: &Job) -> u64 {
    (job.memory / 4 / NODE_BYTES).clamp(1024, MAX_NODES)
}

/// Mean and spread of the heights nearest to each node.
pub(super) struct Mean<'a> {
    frame: &'a Frame,
    /// Heights are summed relative to the first one: f32 then holds millimetres.
    base: Option<f64>,
    sums: Vec<f32>,
    squares: Vec<f32>,
    counts: Vec<u32>,
}

impl<'a> Mean<'a> {
    pub(super) fn new(frame: &'a Frame) -> Self {
        let nodes = frame.nodes();
        Self {
            frame,
            base: None,
            sums: vec![0.0; nodes],
            squares: vec![0.0; nodes],
            counts: vec![0; nodes],
        }
    }

    pub(super) fn add(&mut self, p: DVec3) {
        let Some(node) = self.frame.nearest(p) else { return };
        let height = (p.z - *self.base.get_or_insert(p.z)) as f32;
        self.counts[node] = self.counts[node].saturating_add(1);
        // Running mean and sum of squared deviations (Welford): sums of many heights would
        // outgrow an f32.
        let deviation = height - self.sums[node];
        self.sums[node] += deviation / self.counts[node] as f32;
        self.squares[node] += deviation * (height - self.sums[node]);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.base.is_none()
    }

    /// The grid of means, gaps filled. Its uncertainty is the root mean square of the
    /// deviations from them.
    pub(super) fn grid(self) -> GroundGrid {
        let mut grid = self.frame.grid();
        let base = self.base.unwrap_or_default();
        let (mut squares, mut count) = (0.0, 0u64);
        for (node, height) in grid.heights.iter_mut().enumerate() {
            if self.counts[node] > 0 {
                *height = (base + f64::from(self.sums[node])) as f32;
                squares += f64::from(self.squares[node]);
                count += u64::from(self.counts[node]);
            }
        }
        grid.uncertainty_m = (squares / count.max(1) as f64).sqrt();
        fill(&mut grid);
        grid
    }
}

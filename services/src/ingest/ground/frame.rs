//! Where a grid's nodes are.

use flaneur_scene::Bounds2;
use glam::{DVec2, DVec3};

use crate::layers::ground::{GroundGrid, MAX_SIDE};

/// The ground reaches this far beyond the street, metres.
const MARGIN_M: f64 = 16.0;

/// The finest spacing, metres: kerbs and gutters are finer, but the ground only carries the
/// photographs.
const FINEST_M: f64 = 1.0;

/// A grid without its heights.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    /// The south-west node.
    pub(super) origin: DVec2,
    /// Distance between nodes, metres.
    pub(super) spacing_m: f64,
    pub(super) columns: u32,
    pub(super) rows: u32,
}

impl Frame {
    /// The finest frame around `extent`, margin included, with at most `most_nodes` ≥ 4 nodes.
    /// The spacing is a power of two, and the nodes are multiples of it, so that the f64
    /// coordinates of nodes are exact.
    pub(super) fn around(extent: &Bounds2, most_nodes: u64) -> Self {
        let (min, max) = (extent.min - MARGIN_M, extent.max + MARGIN_M);
        let mut spacing_m = FINEST_M;
        loop {
            let origin = (min / spacing_m).floor() * spacing_m;
            let sides = ((max - origin) / spacing_m).ceil().max(DVec2::ONE) + 1.0;
            let fits = sides.max_element() <= f64::from(MAX_SIDE)
                && sides.element_product() <= most_nodes.max(4) as f64;
            if fits {
                return Self { origin, spacing_m, columns: sides.x as u32, rows: sides.y as u32 };
            }
            spacing_m *= 2.0;
        }
    }

    /// The grid, every height unknown.
    pub(super) fn grid(&self) -> GroundGrid {
        GroundGrid {
            origin: self.origin,
            spacing_m: self.spacing_m,
            columns: self.columns,
            rows: self.rows,
            heights: vec![f32::NAN; self.nodes()],
            uncertainty_m: 0.0,
        }
    }

    pub(super) fn nodes(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// The node nearest to `p`, if `p` is within half a cell of the grid.
    pub(super) fn nearest(&self, p: DVec3) -> Option<usize> {
        let at = ((p.truncate() - self.origin) / self.spacing_m).round();
        let inside = at.cmpge(DVec2::ZERO).all()
            && at.x < f64::from(self.columns)
            && at.y < f64::from(self.rows)
            && p.z.is_finite();
        inside.then(|| at.y as usize * self.columns as usize + at.x as usize)
    }

    /// World position of a node.
    pub(super) fn position(&self, node: usize) -> DVec2 {
        let (row, column) = (node / self.columns as usize, node % self.columns as usize);
        self.origin + DVec2::new(column as f64, row as f64) * self.spacing_m
    }
}

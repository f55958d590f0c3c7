//! Sparse heights joined by a Delaunay triangulation.

use glam::DVec3;
use spade::{DelaunayTriangulation, FloatTriangulation, HasPosition, Point2, Triangulation};

use super::REACH_M;
use super::frame::Frame;
use crate::ingest::{IngestError, Job};
use crate::layers::ground::GroundGrid;

/// A listed height, relative to the frame's origin, where rounding does not matter.
struct Vertex {
    position: Point2<f64>,
    height: f64,
}

impl HasPosition for Vertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// The heights at the nodes of `frame`: linear on the triangles between samples; outside of
/// them that of the nearest sample, up to [`REACH_M`] away.
pub(super) fn grid(job: &Job, samples: &[DVec3], frame: &Frame) -> Result<GroundGrid, IngestError> {
    let vertices = samples.iter().map(|sample| {
        let plan = sample.truncate() - frame.origin;
        Vertex { position: clamped(plan.x, plan.y), height: sample.z }
    });
    let tin = DelaunayTriangulation::<Vertex>::bulk_load(vertices.collect())
        .expect("listed heights are finite and within the range of the triangulation");
    let interpolate = tin.barycentric();
    let mut grid = frame.grid();
    for (node, height) in grid.heights.iter_mut().enumerate() {
        if node % (1 << 16) == 0 {
            job.check()?;
        }
        let plan = frame.position(node) - frame.origin;
        let at = clamped(plan.x, plan.y);
        let found = interpolate.interpolate(|vertex| vertex.data().height, at).or_else(|| {
            let nearest = tin.nearest_neighbor(at)?;
            let reached = nearest.position().distance_2(at) <= REACH_M * REACH_M;
            reached.then(|| nearest.data().height)
        });
        if let Some(found) = found {
            *height = found as f32;
        }
    }
    Ok(grid)
}

/// The triangulation refuses numbers that are nearly zero (below 1e-142) but are not.
fn clamped(x: f64, y: f64) -> Point2<f64> {
    let clamp = |v: f64| if v.abs() < 1e-100 { 0.0 } else { v };
    Point2::new(clamp(x), clamp(y))
}

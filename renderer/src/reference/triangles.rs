//! The mesh as a set of triangles, asked ray by ray.

use std::sync::Arc;

use flaneur_scene::{Bounds3, MeshTile, SurfaceClass};
use glam::{DVec3, Vec3};

use super::Ray;
use super::boxes::Boxes;
use crate::mesh;

/// All triangles of a scene, world frame.
#[derive(Debug)]
pub(super) struct Triangles {
    triangles: Vec<Triangle>,
    boxes: Boxes,
}

#[derive(Debug)]
struct Triangle {
    corners: [DVec3; 3],
    /// Unit, as its first vertex says.
    normal: DVec3,
    uncertainty_m: [f64; 3],
    class: SurfaceClass,
}

/// Where a ray meets the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) depth_m: f64,
    /// Unit, towards the ray's origin.
    pub(super) normal: DVec3,
    pub(super) uncertainty_m: f64,
    pub(super) class: SurfaceClass,
}

impl Triangles {
    /// The triangles of `tiles`, those with a corner that is not finite left out.
    pub(super) fn new<'a>(tiles: impl Iterator<Item = &'a Arc<MeshTile>>) -> Self {
        let triangles: Vec<Triangle> = tiles.flat_map(|tile| of_tile(tile)).collect();
        let bounds: Vec<Bounds3> = triangles
            .iter()
            .map(|triangle| {
                let mut bounds = Bounds3::EMPTY;
                triangle.corners.into_iter().for_each(|corner| bounds.include(corner));
                bounds
            })
            .collect();
        Self { triangles, boxes: Boxes::new(&bounds) }
    }

    /// Around all of them.
    pub(super) fn bounds(&self) -> Bounds3 {
        let mut bounds = Bounds3::EMPTY;
        self.triangles.iter().flat_map(|t| t.corners).for_each(|corner| bounds.include(corner));
        bounds
    }

    /// The nearest triangle on a ray, from `near_m` on; of several at one depth the first in the
    /// order of tiles.
    pub(super) fn first(&self, ray: &Ray, near_m: f64) -> Option<Hit> {
        let found = self.boxes.first(ray, |item| {
            let hit = meet(&self.triangles[item], ray).filter(|hit| hit.depth_m >= near_m)?;
            Some((hit.depth_m, hit))
        })?;
        Some(found.hit)
    }
}

fn of_tile(tile: &MeshTile) -> Vec<Triangle> {
    let triangle = |indices: &[u32]| {
        let vertex = |i: usize| tile.vertices.get(*indices.get(i)? as usize);
        let vertices = [vertex(0)?, vertex(1)?, vertex(2)?];
        let corners = vertices.map(|v| tile.origin + Vec3::from_array(v.position).as_dvec3());
        corners.iter().all(|corner| corner.is_finite()).then(|| Triangle {
            corners,
            normal: Vec3::from_array(vertices[0].normal).as_dvec3().normalize_or(DVec3::Z),
            uncertainty_m: vertices.map(|v| f64::from(mesh::usable(v.uncertainty_m))),
            class: vertices[0].class,
        })
    };
    tile.indices.chunks_exact(3).filter_map(triangle).collect()
}

/// The ray against the triangle: `o + t d = a + u (b − a) + v (c − a)`, by Cramer's rule.
fn meet(triangle: &Triangle, ray: &Ray) -> Option<Hit> {
    // Rays through the edge between two triangles meet at least one.
    const EDGE: f64 = 1e-12;
    let [a, b, c] = triangle.corners;
    let (ab, ac, ao) = (b - a, c - a, ray.origin - a);
    let across = ray.direction.cross(ac);
    let determinant = ab.dot(across);
    let u = ao.dot(across) / determinant;
    let along = ao.cross(ab);
    let v = ray.direction.dot(along) / determinant;
    let depth_m = ac.dot(along) / determinant;
    // Written so that what is no number (a ray in the plane) meets nothing.
    if !(u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE) {
        return None;
    }
    let away = triangle.normal.dot(ray.direction) > 0.0;
    let [at_a, at_b, at_c] = triangle.uncertainty_m;
    Some(Hit {
        depth_m,
        normal: if away { -triangle.normal } else { triangle.normal },
        uncertainty_m: at_a + u * (at_b - at_a) + v * (at_c - at_a),
        class: triangle.class,
    })
}

//! What a camera can see, for leaving out what it cannot.

use flaneur_scene::{Bounds3, PosedCamera, View, ViewProjection};
use glam::{DVec2, DVec3};

use crate::pinhole::Pinhole;

/// How far a frustum reaches when two are compared, metres.
const REACH_M: f64 = 1e4;

/// The pyramid that a pinhole sees, or the shaft that an orthographic view does.
#[derive(Clone, Debug)]
pub(crate) struct Frustum {
    /// Inward normals, world frame, with a place on each plane: four sides, and the eye's.
    planes: [(DVec3, DVec3); 5],
    /// On the plane of the eye, and far away.
    corners: [DVec3; 8],
}

impl Frustum {
    /// What a pinhole at the camera's place sees.
    pub(crate) fn new(camera: &PosedCamera, pinhole: &Pinhole) -> Self {
        let world_from_cam = camera.cam_from_world.transpose();
        let (f, c, size) = (pinhole.focal, pinhole.centre, pinhole.size.as_dvec2());
        let planes = [
            DVec3::new(f.x, 0.0, c.x),
            DVec3::new(-f.x, 0.0, size.x - c.x),
            DVec3::new(0.0, f.y, c.y),
            DVec3::new(0.0, -f.y, size.y - c.y),
            DVec3::Z,
        ]
        .map(|n| (world_from_cam * n.normalize(), camera.centre));
        let far =
            corners(pinhole).map(|m| camera.centre + world_from_cam * m.extend(1.0) * REACH_M);
        let [a, b, c, d] = far;
        Self {
            planes,
            corners: [camera.centre, camera.centre, camera.centre, camera.centre, a, b, c, d],
        }
    }

    /// What a view sees whose G-buffer is `pinhole`.
    pub(crate) fn of_view(view: &View, pinhole: &Pinhole) -> Self {
        let camera = &view.camera;
        if view.projection == ViewProjection::Perspective {
            return Self::new(camera, pinhole);
        }
        let world_from_cam = camera.cam_from_world.transpose();
        let near = corners(pinhole).map(|m| camera.centre + world_from_cam * m.extend(0.0));
        let [a, b, c, d] = near;
        let reach = camera.forward() * REACH_M;
        let planes = [
            (DVec3::X, a),
            (DVec3::NEG_X, d),
            (DVec3::Y, a),
            (DVec3::NEG_Y, d),
            (DVec3::Z, camera.centre),
        ]
        .map(|(n, place)| (world_from_cam * n, place));
        let corners = [a, b, c, d, a + reach, b + reach, c + reach, d + reach];
        Self { planes, corners }
    }

    /// Inward normals, world frame, with a place on each plane: four sides, and the eye's.
    pub(crate) fn planes(&self) -> [(DVec3, DVec3); 5] {
        self.planes
    }

    /// Whether anything of the box, grown by `margin_m`, may be seen. Never wrongly false.
    pub(crate) fn meets_box(&self, bounds: &Bounds3, margin_m: f64) -> bool {
        self.planes.iter().all(|(n, place)| {
            let farthest = DVec3::select(n.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
            n.dot(farthest - place) >= -margin_m * n.abs().element_sum()
        })
    }

    /// Whether something within 10 km may be seen by both. Never wrongly false.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        self.has_a_corner_of(other) && other.has_a_corner_of(self)
    }

    /// Whether no plane has all of `other` outside.
    fn has_a_corner_of(&self, other: &Self) -> bool {
        self.planes
            .iter()
            .all(|(n, place)| other.corners.iter().any(|corner| n.dot(corner - place) >= 0.0))
    }
}

/// Top left, top right, bottom left and bottom right on the plane at depth 1.
fn corners(pinhole: &Pinhole) -> [DVec2; 4] {
    let size = pinhole.size.as_dvec2();
    [DVec2::ZERO, size.with_y(0.0), size.with_x(0.0), size]
        .map(|corner| (corner - pinhole.centre) / pinhole.focal)
}

//! What a pinhole can see, for leaving out what it cannot.

use flaneur_scene::{Bounds3, PosedCamera};
use glam::{DVec2, DVec3};

use crate::pinhole::Pinhole;

/// How far a pyramid reaches when two are compared, metres.
const REACH_M: f64 = 1e4;

/// The pyramid that a pinhole sees: planes through its centre, and corners far away.
#[derive(Clone, Debug)]
pub(crate) struct Frustum {
    apex: DVec3,
    /// Inward normals, world frame: four sides, and forward.
    inward: [DVec3; 5],
    far_corners: [DVec3; 4],
}

impl Frustum {
    pub(crate) fn new(camera: &PosedCamera, pinhole: &Pinhole) -> Self {
        let world_from_cam = camera.cam_from_world.transpose();
        let (f, c, size) = (pinhole.focal, pinhole.centre, pinhole.size.as_dvec2());
        let inward = [
            DVec3::new(f.x, 0.0, c.x),
            DVec3::new(-f.x, 0.0, size.x - c.x),
            DVec3::new(0.0, f.y, c.y),
            DVec3::new(0.0, -f.y, size.y - c.y),
            DVec3::Z,
        ]
        .map(|n| world_from_cam * n.normalize());
        let far_corners =
            [(0.0, 0.0), (size.x, 0.0), (0.0, size.y), (size.x, size.y)].map(|(u, v)| {
                let direction = ((DVec2::new(u, v) - c) / f).extend(1.0);
                camera.centre + world_from_cam * direction * REACH_M
            });
        Self { apex: camera.centre, inward, far_corners }
    }

    /// Inward normals of the planes through the apex, world frame: four sides, and forward.
    pub(crate) fn inward(&self) -> [DVec3; 5] {
        self.inward
    }

    /// Whether anything of the box, grown by `margin_m`, may be seen. Never wrongly false.
    pub(crate) fn meets_box(&self, bounds: &Bounds3, margin_m: f64) -> bool {
        self.inward.iter().all(|n| {
            let farthest = DVec3::select(n.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
            n.dot(farthest - self.apex) >= -margin_m * n.abs().element_sum()
        })
    }

    /// Whether something within 10 km may be seen by both. Never wrongly false.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        self.has_a_corner_of(other) && other.has_a_corner_of(self)
    }

    /// Whether no plane has all of `other`'s pyramid outside.
    fn has_a_corner_of(&self, other: &Self) -> bool {
        self.inward.iter().all(|n| {
            let inside = |p: DVec3| n.dot(p - self.apex) >= 0.0;
            inside(other.apex) || other.far_corners.into_iter().any(inside)
        })
    }
}

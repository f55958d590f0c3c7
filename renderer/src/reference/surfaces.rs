//! Which surface each pixel of a view shows.

use flaneur_scene::{Distortion, View, ViewProjection};
use glam::{DVec2, DVec3};

use super::Ray;
use super::colour::What;
use super::discs::{Discs, Point, Target};
use super::field::Field;
use super::triangles::Triangles;
use crate::Mode;
use crate::camera::nearest_depth;
use crate::pinhole::MAX_TANGENT;
use crate::surface::reference::{self as hybrid, DiscHit, MeshHit, Shown};

/// What a pixel sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel {
    /// Direction, world axes, of depth 1 along the view's axis; zero where its lens sees nothing.
    pub(super) ray: DVec3,
    /// `None` where there is nothing.
    pub(super) met: Option<Met>,
}

/// Where the ray of a pixel ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    /// Relative to the eye, metres, world axes.
    pub(super) position: DVec3,
    pub(super) shown: Shown,
    pub(super) what: What,
}

/// What all pixels of a view see.
pub(super) fn shown(view: &View, mode: Mode, mesh: &Triangles, points: &[Point]) -> Field<Pixel> {
    let intrinsics = view.camera.lens.intrinsics;
    let focal = intrinsics.fx.min(intrinsics.fy);
    let drawn: &[Point] = if mode == Mode::Mesh { &[] } else { points };
    let eye = Eye {
        view,
        mesh: (!matches!(mode, Mode::Points | Mode::PointsColour)).then_some(mesh),
        points,
        discs: Discs::new(drawn, &view.camera, focal, Target::View(view.projection)),
    };
    Field::new(view.size(), |pixel| eye.pixel(pixel.as_dvec2() + 0.5))
}

/// Everything that one view sees.
struct Eye<'a> {
    view: &'a View,
    mesh: Option<&'a Triangles>,
    points: &'a [Point],
    discs: Discs,
}

impl Eye<'_> {
    fn pixel(&self, pixel: DVec2) -> Pixel {
        let Some(in_camera) = self.ray(pixel) else {
            return Pixel { ray: DVec3::ZERO, met: None };
        };
        let eye = self.view.eye();
        let world_from_cam = self.view.camera.cam_from_world.transpose();
        let origin = world_from_cam * in_camera.origin;
        let direction = world_from_cam * in_camera.direction;
        let near_m = nearest_depth(self.view.projection).into();
        let world_ray = Ray { origin: eye + origin, direction };
        let mesh = self.mesh.and_then(|mesh| mesh.first(&world_ray, near_m));
        let disc = self.discs.first(&in_camera);
        let mesh_hit = mesh.map(|hit| MeshHit {
            depth_m: hit.depth_m,
            normal: hit.normal,
            uncertainty_m: hit.uncertainty_m,
        });
        let disc_hit = disc.map(|hit| {
            let point = &self.points[hit.index];
            let toward = match self.view.projection {
                ViewProjection::Perspective => (eye - point.position).normalize_or_zero(),
                ViewProjection::Orthographic => -direction,
            };
            DiscHit {
                depth_m: hit.depth_m,
                point: point.position - eye,
                normal: point.disc_normal(toward),
                has_normal: point.has_normal(),
            }
        });
        let Some(shown) = hybrid::shown(origin, direction, mesh_hit, disc_hit) else {
            return Pixel { ray: direction, met: None };
        };
        let what = match (shown.is_point, mesh, disc) {
            (false, Some(hit), _) => {
                What::Mesh { uncertainty_m: hit.uncertainty_m, class: hit.class }
            }
            (_, _, hit) => {
                What::Point { colour: hit.and_then(|hit| self.points[hit.index].colour) }
            }
        };
        let position = origin + direction * shown.depth_m;
        Pixel { ray: direction, met: Some(Met { position, shown, what }) }
    }

    /// What a raw pixel position sees, camera frame. What lies more than 80° off the axis of a
    /// distorted view is not drawn.
    fn ray(&self, pixel: DVec2) -> Option<Ray> {
        let lens = &self.view.camera.lens;
        let direction = lens.unproject(pixel)?;
        let off_axis = direction.truncate().abs().max_element();
        let drawn = lens.distortion == Distortion::None || off_axis <= MAX_TANGENT;
        drawn.then_some(match self.view.projection {
            ViewProjection::Perspective => Ray { origin: DVec3::ZERO, direction },
            ViewProjection::Orthographic => {
                Ray { origin: direction.with_z(0.0), direction: DVec3::Z }
            }
        })
    }
}

//! What a person looks at: an eye, a direction, and a picture's size.

use glam::{DMat3, DVec2, DVec3, UVec2};

use crate::{Intrinsics, Lens, PosedCamera, world_from_rig};

/// Camera axes (x right, y down, z forward) of a rig that looks along its y axis.
const CAM_FROM_RIG: DMat3 = DMat3::from_cols_array(&[1., 0., 0., 0., 0., 1., 0., -1., 0.]);

/// A view to be rendered: the camera whose picture is wanted. The picture has the size
/// of its lens, and its lens's distortion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera. The focal lengths of an orthographic one are in pixels a metre, and it has no
    /// distortion.
    pub camera: PosedCamera,
    /// How its rays run.
    pub projection: ViewProjection,
}

/// How the rays of a view run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ViewProjection {
    /// Through the eye.
    #[default]
    Perspective,
    /// Parallel to the axis, from the plane through the eye: a plan, or an elevation.
    Orthographic,
}

/// A ray of a view, world frame: at depth z along the axis it is at `origin + z direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it is on the plane of the eye, metres.
    pub origin: DVec3,
    /// Its way, of depth 1 along the axis.
    pub direction: DVec3,
}

impl From<PosedCamera> for View {
    /// What the camera sees.
    fn from(camera: PosedCamera) -> Self {
        Self { camera, projection: ViewProjection::Perspective }
    }
}

impl View {
    /// The view from `eye` (world, metres) towards `heading` (clockwise from grid north) and
    /// `pitch` (up), with a vertical field of view of `fov_y`; angles in radians.
    pub fn look(eye: DVec3, heading: f64, pitch: f64, fov_y: f64, size: UVec2) -> Self {
        let cam_from_world = CAM_FROM_RIG * world_from_rig(heading, pitch, 0.0).transpose();
        let lens = Lens::pinhole(size, Intrinsics::from_fov_y(fov_y, size));
        PosedCamera { centre: eye, cam_from_world, lens }.into()
    }

    /// The same without perspective: the picture is `height_m` metres high everywhere, and
    /// shows what lies before the plane through `eye`.
    pub fn orthographic(eye: DVec3, heading: f64, pitch: f64, height_m: f64, size: UVec2) -> Self {
        let mut view = Self::look(eye, heading, pitch, 1.0, size);
        let pixels_a_metre = f64::from(size.y) / height_m;
        view.camera.lens.intrinsics.fx = pixels_a_metre;
        view.camera.lens.intrinsics.fy = pixels_a_metre;
        view.projection = ViewProjection::Orthographic;
        view
    }

    /// The ray of a pixel position, or `None` where the lens reaches no such pixel.
    pub fn ray(&self, pixel: DVec2) -> Option<Ray> {
        let world_from_cam = self.camera.cam_from_world.transpose();
        let direction = self.camera.lens.unproject(pixel)?;
        Some(match self.projection {
            ViewProjection::Perspective => {
                Ray { origin: self.camera.centre, direction: world_from_cam * direction }
            }
            ViewProjection::Orthographic => Ray {
                origin: self.camera.centre + world_from_cam * direction.with_z(0.0),
                direction: self.camera.forward(),
            },
        })
    }

    /// Vertical pixels a metre, near the axis, at a depth in metres.
    pub fn pixels_a_metre(&self, depth_m: f64) -> f64 {
        match self.projection {
            ViewProjection::Perspective => self.camera.lens.intrinsics.fy / depth_m,
            ViewProjection::Orthographic => self.camera.lens.intrinsics.fy,
        }
    }

    /// The eye, world frame, metres.
    pub fn eye(&self) -> DVec3 {
        self.camera.centre
    }

    /// Size of the picture in pixels.
    pub fn size(&self) -> UVec2 {
        self.camera.lens.size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_of_an_orthographic_view_are_parallel() {
        let eye = DVec3::new(651_000.0, 6_861_000.0, 140.0);
        // Straight down, north up: 50 m high, 100 m wide.
        let down = -90f64.to_radians();
        let view = View::orthographic(eye, 0.0, down, 50.0, UVec2::new(200, 100));
        let ray = view.ray(DVec2::new(200.0, 0.0)).expect("a ray");
        assert!(ray.direction.distance(DVec3::NEG_Z) < 1e-12, "{ray:?}");
        assert!(ray.origin.distance(eye + DVec3::new(50.0, 25.0, 0.0)) < 1e-9, "{ray:?}");
        assert!((view.pixels_a_metre(3.0) - 2.0).abs() < 1e-12);
        let look = View::look(eye, 0.0, 0.0, 1.0, UVec2::new(200, 100));
        let ray = look.ray(DVec2::new(100.0, 50.0)).expect("a ray");
        assert!(ray.origin == eye && ray.direction.distance(DVec3::Y) < 1e-12, "{ray:?}");
    }

    #[test]
    fn what_lies_ahead_is_in_the_middle_and_up_is_up() {
        let eye = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        let view = View::look(eye, 90f64.to_radians(), 0.0, 1.0, UVec2::new(200, 100));
        let (pixel, depth) = view.camera.project(eye + DVec3::X * 10.0).expect("ahead");
        assert!(pixel.distance(DVec2::new(100.0, 50.0)) < 1e-9 && (depth - 10.0).abs() < 1e-9);
        let (pixel, _) = view.camera.project(eye + DVec3::new(10.0, -1.0, 1.0)).expect("ahead");
        assert!(pixel.x > 100.0 && pixel.y < 50.0, "south is right of east, up is up: {pixel}");
    }
}

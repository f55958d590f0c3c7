//! What a person looks at: an eye, a direction, and a picture's size.

use glam::{DMat3, DVec3, UVec2};

use crate::{Intrinsics, Lens, PosedCamera, world_from_rig};

/// Camera axes (x right, y down, z forward) of a rig that looks along its y axis.
const CAM_FROM_RIG: DMat3 = DMat3::from_cols_array(&[1., 0., 0., 0., 0., 1., 0., -1., 0.]);

/// A view to be rendered: the camera whose picture is wanted. The picture has the size
/// of its lens, and its lens's distortion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: PosedCamera,
}

impl View {
    /// The view from `eye` (world, metres) towards `heading` (clockwise from grid north) and
    /// `pitch` (up), with a vertical field of view of `fov_y`; angles in radians.
    pub fn look(eye: DVec3, heading: f64, pitch: f64, fov_y: f64, size: UVec2) -> Self {
        let cam_from_world = CAM_FROM_RIG * world_from_rig(heading, pitch, 0.0).transpose();
        let lens = Lens::pinhole(size, Intrinsics::from_fov_y(fov_y, size));
        Self { camera: PosedCamera { centre: eye, cam_from_world, lens } }
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
    use glam::DVec2;

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

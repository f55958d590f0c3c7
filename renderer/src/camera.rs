//! A posed pinhole, as the rasterising passes see it.

use flaneur_scene::{PosedCamera, View, ViewProjection};

use crate::pinhole::Pinhole;

/// Nearest depth that is drawn, metres. Depth on the device is `NEAR_M / z`: reversed, with
/// an infinite far plane.
pub(crate) const NEAR_M: f32 = 0.05;

/// Nearest depth that a view draws, metres: an orthographic one begins at the plane of its eye.
pub(crate) fn nearest_depth(projection: ViewProjection) -> f32 {
    match projection {
        ViewProjection::Perspective => NEAR_M,
        ViewProjection::Orthographic => 0.0,
    }
}

/// The WGSL side, to be put before the shaders that use it.
pub(crate) const WGSL: &str = include_str!("camera.wgsl");

pub(crate) mod gpu_data {
    /// Mirrors `Camera` in camera.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Camera {
        pub(crate) right: [f32; 3],
        pub(crate) near: f32,
        pub(crate) down: [f32; 3],
        pub(crate) orthographic: u32,
        pub(crate) forward: [f32; 3],
        pub(crate) padding_1: u32,
        pub(crate) focal: [f32; 2],
        pub(crate) centre: [f32; 2],
        pub(crate) size: [u32; 2],
        pub(crate) padding_2: [u32; 2],
    }
}

impl gpu_data::Camera {
    /// The camera of a view whose G-buffer is `pinhole`.
    pub(crate) fn of_view(view: &View, pinhole: &Pinhole) -> Self {
        let orthographic = u32::from(view.projection == ViewProjection::Orthographic);
        let near = nearest_depth(view.projection);
        Self { orthographic, near, ..Self::new(&view.camera, pinhole) }
    }

    pub(crate) fn new(camera: &PosedCamera, pinhole: &Pinhole) -> Self {
        let axes = camera.cam_from_world.transpose();
        Self {
            right: axes.x_axis.as_vec3().to_array(),
            near: NEAR_M,
            down: axes.y_axis.as_vec3().to_array(),
            orthographic: 0,
            forward: axes.z_axis.as_vec3().to_array(),
            padding_1: 0,
            focal: pinhole.focal.as_vec2().to_array(),
            centre: pinhole.centre.as_vec2().to_array(),
            size: pinhole.size.to_array(),
            padding_2: [0; 2],
        }
    }
}

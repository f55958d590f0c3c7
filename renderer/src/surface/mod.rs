//! Which surface each pixel of the picture shows: mesh and points merged by the hybrid rule.
//!
//! The G-buffer is that of an ideal camera; here each pixel of the picture, through its own
//! lens, gets one record, which the passes after this one read.

use wgpu::util::DeviceExt as _;

use crate::bindings::Bindings;
use crate::screen::{ScreenPass, VIEWPORT_WGSL, screen_pass_with};
use crate::settings::SplatNormals;
use crate::targets::Targets;
use crate::{Gpu, camera, lens, octahedral, splat};

pub(crate) mod reference;

/// The records, to be put before the shaders that read them.
pub(crate) const PLACE_WGSL: &str = include_str!("place.wgsl");

pub(crate) const POSITION_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
pub(crate) const ORIENTATION_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;

/// The whole shader.
pub(crate) fn wgsl() -> String {
    let surface = include_str!("surface.wgsl");
    let shared = [camera::WGSL, lens::WGSL, octahedral::WGSL, PLACE_WGSL, splat::PLANE_WGSL];
    [&shared.concat(), VIEWPORT_WGSL, surface].concat()
}

pub(crate) mod gpu_data {
    use crate::camera::gpu_data::Camera;
    use crate::lens::gpu_data::Lens;

    /// Mirrors `View` in surface.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct View {
        pub(crate) camera: Camera,
        pub(crate) lens: Lens,
        pub(crate) grid_columns: u32,
        pub(crate) grid_step: f32,
        pub(crate) padding: [u32; 2],
    }
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct SurfacePass {
    /// One a lens model.
    passes: [ScreenPass; lens::MODELS],
}

impl SurfacePass {
    pub(crate) fn new(gpu: &Gpu, normals: SplatNormals) -> Self {
        let with_normals = f64::from(u8::from(normals == SplatNormals::Estimated));
        let formats = [POSITION_FORMAT, ORIENTATION_FORMAT];
        let pass = |model: usize| {
            let constants = [("LENS_MODEL", model as f64), ("WITH_NORMALS", with_normals)];
            screen_pass_with(gpu, "surface", &wgsl(), &formats, &constants)
        };
        Self { passes: std::array::from_fn(pass) }
    }

    /// Fills the orientations of `targets` and `positions` for every pixel of the picture. `grid` is that of
    /// a distorted view.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        view: &gpu_data::View,
        grid: &[[f32; 2]],
        targets: &Targets,
        positions: &wgpu::TextureView,
    ) {
        let buffer = |contents: &[u8], usage| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("surface"),
                contents,
                usage,
            })
        };
        let uniform = buffer(bytemuck::bytes_of(view), wgpu::BufferUsages::UNIFORM);
        // Bindings cannot be empty.
        let grid = if grid.is_empty() { &[[0.0; 2]] } else { grid };
        let grid = buffer(bytemuck::cast_slice(grid), wgpu::BufferUsages::STORAGE);
        let bindings: Bindings<'_> = vec![
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(&targets.planes),
            wgpu::BindingResource::TextureView(&targets.surfaces),
            wgpu::BindingResource::TextureView(&targets.winners),
            wgpu::BindingResource::TextureView(&targets.winning_normals),
            grid.as_entire_binding(),
        ];
        let pass = &self.passes[view.lens.model as usize % lens::MODELS];
        pass.draw(gpu, encoder, bindings, &[positions, &targets.records.orientations]);
    }
}

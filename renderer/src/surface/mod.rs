//! Which surface each pixel of the picture shows: mesh and points merged by the hybrid rule.
//!
//! The G-buffer is that of an ideal camera; here each pixel of the picture, through its own
//! lens, gets one record, which the passes after this one read.

use flaneur_scene::Lens;
use wgpu::util::DeviceExt as _;

use crate::bindings::Bindings;
use crate::camera::gpu_data::Camera;
use crate::screen::{Marks, ScreenPass, VIEWPORT_WGSL, marked_pass};
use crate::settings::SplatNormals;
use crate::targets::{Records, Targets};
use crate::{Gpu, camera, lens, octahedral, splat};

pub(crate) mod reference;

/// The records, to be put before the shaders that read them.
pub(crate) const PLACE_WGSL: &str = include_str!("place.wgsl");

pub(crate) const POSITION_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
pub(crate) const ORIENTATION_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;

/// The whole shader.
pub(crate) fn wgsl() -> String {
    let shared = [octahedral::WGSL, PLACE_WGSL, splat::PLANE_WGSL, include_str!("surface.wgsl")];
    [&ray_wgsl(), &shared.concat()[..]].concat()
}

/// The rays of a picture's pixels, to be put before the shaders that follow them.
pub(crate) fn ray_wgsl() -> String {
    [camera::WGSL, lens::WGSL, VIEWPORT_WGSL, include_str!("ray.wgsl")].concat()
}

pub(crate) mod gpu_data {
    use crate::camera::gpu_data::Camera;
    use crate::lens::gpu_data::Lens;

    /// Mirrors `View` in ray.wgsl.
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

/// The rays of a picture's pixels on the device.
#[derive(Debug)]
pub(crate) struct Rays {
    view: wgpu::Buffer,
    grid: wgpu::Buffer,
    model: usize,
}

impl Rays {
    /// Of the pinhole `camera`, as the picture's `lens` has them.
    pub(crate) fn new(gpu: &Gpu, camera: Camera, lens: &Lens) -> Self {
        let data = lens::gpu_data::Lens::new(lens);
        // Without distortion it is not asked, but bindings cannot be empty.
        let grid = if data.model == 0 { vec![[0.0; 2]] } else { lens::undistortion_grid(lens) };
        let view = gpu_data::View {
            camera,
            lens: data,
            grid_columns: lens::grid_size(lens.size).x,
            grid_step: lens::GRID_STEP as f32,
            padding: [0; 2],
        };
        let buffer = |contents: &[u8], usage| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("rays"),
                contents,
                usage,
            })
        };
        Self {
            view: buffer(bytemuck::bytes_of(&view), wgpu::BufferUsages::UNIFORM),
            grid: buffer(bytemuck::cast_slice(&grid), wgpu::BufferUsages::STORAGE),
            model: data.model as usize % lens::MODELS,
        }
    }

    /// What ray.wgsl binds, first.
    pub(crate) fn bindings(&self) -> [wgpu::BindingResource<'_>; 2] {
        [self.view.as_entire_binding(), self.grid.as_entire_binding()]
    }

    /// The one for their lens, of passes one a lens model.
    pub(crate) fn pass<'a>(&self, passes: &'a [ScreenPass; lens::MODELS]) -> &'a ScreenPass {
        &passes[self.model]
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
            marked_pass(gpu, "surface", &wgsl(), &formats, &constants, Marks::Leaves)
        };
        Self { passes: std::array::from_fn(pass) }
    }

    /// Fills the records of `targets` for every pixel of the picture, and marks those of which nothing is known.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        rays: &Rays,
        targets: &Targets,
    ) {
        let read = [&targets.planes, &targets.surfaces, &targets.winners, &targets.winning_normals];
        let mut bindings: Bindings<'_> = rays.bindings().into();
        bindings.extend(read.map(wgpu::BindingResource::TextureView));
        let Records { positions, orientations } = &targets.records;
        let written = [positions, orientations];
        let pass = rays.pass(&self.passes);
        pass.draw_marked(gpu, encoder, bindings, &written, &targets.marks);
    }
}

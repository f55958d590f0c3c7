//! Deferred multi-texture blending: the last pass of a frame.

use std::sync::OnceLock;

use wgpu::util::DeviceExt as _;

use crate::depth_map::DepthMaps;
use crate::photographs::atlas::{self, Atlas};
use crate::{Gpu, camera, depth_map, lens};

#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;
pub(crate) mod tiles;

/// The weights, to be put before the shader that uses them.
pub(crate) const BLEND_WGSL: &str = include_str!("blend.wgsl");

/// The whole shader.
pub(crate) fn wgsl() -> String {
    [camera::WGSL, lens::WGSL, depth_map::WGSL, BLEND_WGSL, include_str!("shade.wgsl")].concat()
}

pub(crate) mod gpu_data {
    use crate::camera::gpu_data::Camera;
    use crate::lens::gpu_data::Lens;

    /// Mirrors `Frame` in shade.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Frame {
        pub(crate) camera: Camera,
        pub(crate) lens: Lens,
        pub(crate) background: [f32; 3],
        pub(crate) photograph_count: u32,
        pub(crate) grid_columns: u32,
        pub(crate) grid_step: f32,
        pub(crate) map_side: u32,
        pub(crate) tile_columns: u32,
    }

    /// Mirrors `Photograph` in shade.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Photograph {
        pub(crate) lens: Lens,
        pub(crate) right: [f32; 3],
        pub(crate) rig: u32,
        pub(crate) down: [f32; 3],
        pub(crate) map_layer: u32,
        pub(crate) forward: [f32; 3],
        pub(crate) eye_distance_2: f32,
        pub(crate) centre: [f32; 3],
        pub(crate) atlas: u32,
        pub(crate) map_focal: [f32; 2],
        pub(crate) map_centre: [f32; 2],
        pub(crate) map_size: [u32; 2],
        pub(crate) layer: u32,
        pub(crate) max_lod: f32,
        pub(crate) corner: [f32; 2],
        pub(crate) texel: f32,
        pub(crate) padding: u32,
    }
}

/// What the geometry passes left behind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GBuffer<'a> {
    pub(crate) planes: &'a wgpu::TextureView,
    pub(crate) surfaces: &'a wgpu::TextureView,
    pub(crate) winners: &'a wgpu::TextureView,
    pub(crate) indices: &'a wgpu::Buffer,
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct ShadePass {
    module: wgpu::ShaderModule,
    /// One for each set of atlases in use, made when first needed: bit i stands for atlas i.
    pipelines: [OnceLock<wgpu::ComputePipeline>; 1 << atlas::SIDES.len()],
    filtering: wgpu::Sampler,
}

impl gpu_data::Photograph {
    /// The photograph as seen from `eye`; `rig` tells those of one panorama from others.
    pub(crate) fn new(
        photograph: &crate::photographs::Photograph,
        eye: glam::DVec3,
        rig: u32,
        map_layer: u32,
    ) -> Self {
        let axes = photograph.camera.cam_from_world.transpose();
        let centre = photograph.camera.centre - eye;
        let place = photograph.place;
        let max_lod = place.size.min_element().ilog2().min(atlas::MAX_LOD);
        Self {
            lens: photograph.lens,
            right: axes.x_axis.as_vec3().to_array(),
            rig,
            down: axes.y_axis.as_vec3().to_array(),
            map_layer,
            forward: axes.z_axis.as_vec3().to_array(),
            eye_distance_2: centre.length_squared() as f32,
            centre: centre.as_vec3().to_array(),
            atlas: place.array as u32,
            map_focal: photograph.map.focal.as_vec2().to_array(),
            map_centre: photograph.map.centre.as_vec2().to_array(),
            map_size: photograph.map.size.to_array(),
            layer: place.layer,
            max_lod: max_lod as f32,
            corner: place.corner.as_vec2().to_array(),
            texel: 1.0 / atlas::SIDES[place.array] as f32,
            padding: 0,
        }
    }
}

impl ShadePass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("shade"),
            source: wgpu::ShaderSource::Wgsl(wgsl().into()),
        });
        let filtering = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("photographs"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        Self { module, pipelines: std::array::from_fn(|_| OnceLock::new()), filtering }
    }

    fn pipeline(&self, gpu: &Gpu, photographs: &[gpu_data::Photograph]) -> &wgpu::ComputePipeline {
        let used = photographs.iter().fold(0, |set, photograph| set | 1 << photograph.atlas);
        self.pipelines[used].get_or_init(|| {
            let constants = ["uses_atlas_0", "uses_atlas_1", "uses_atlas_2", "uses_atlas_3"];
            let constants: Vec<(&str, f64)> = constants
                .into_iter()
                .enumerate()
                .map(|(atlas, name)| (name, f64::from(u8::from(used >> atlas & 1 == 1))))
                .collect();
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("shade"),
                layout: None,
                module: &self.module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..Default::default()
                },
                cache: None,
            })
        })
    }

    /// Writes the picture: a word a pixel, sRGB and the surface's code.
    #[expect(clippy::too_many_arguments, reason = "one argument a source")]
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &gpu_data::Frame,
        gbuffer: GBuffer<'_>,
        photographs: &[gpu_data::Photograph],
        tiles: &[u32],
        grid: &[[f32; 2]],
        maps: &DepthMaps,
        atlas: &Atlas,
        picture: &wgpu::Buffer,
    ) {
        let buffer = |contents: &[u8], usage| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("shade"),
                contents,
                usage,
            })
        };
        let pipeline = self.pipeline(gpu, photographs);
        let uniform = buffer(bytemuck::bytes_of(frame), wgpu::BufferUsages::UNIFORM);
        // Bindings cannot be empty.
        let nobody = [gpu_data::Photograph::default()];
        let photographs = if photographs.is_empty() { &nobody } else { photographs };
        let photographs = buffer(bytemuck::cast_slice(photographs), wgpu::BufferUsages::STORAGE);
        let grid = if grid.is_empty() { &[[0.0; 2]] } else { grid };
        let grid = buffer(bytemuck::cast_slice(grid), wgpu::BufferUsages::STORAGE);
        let tiles = buffer(bytemuck::cast_slice(tiles), wgpu::BufferUsages::STORAGE);
        let map_mesh = maps.mesh_view();
        let atlases = atlas.views();
        let mut entries: Vec<wgpu::BindGroupEntry<'_>> = [
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(gbuffer.planes),
            wgpu::BindingResource::TextureView(gbuffer.surfaces),
            wgpu::BindingResource::TextureView(gbuffer.winners),
            gbuffer.indices.as_entire_binding(),
            photographs.as_entire_binding(),
            wgpu::BindingResource::TextureView(&map_mesh),
            maps.points_buffer().as_entire_binding(),
            grid.as_entire_binding(),
            picture.as_entire_binding(),
            wgpu::BindingResource::Sampler(&self.filtering),
        ]
        .into_iter()
        .zip(0..)
        .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
        .collect();
        entries.extend(atlases.iter().zip(11..).map(|(view, binding)| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::TextureView(view),
        }));
        entries.push(wgpu::BindGroupEntry { binding: 15, resource: tiles.as_entire_binding() });
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shade"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        let groups = frame.lens.size.map(|side| (side as u32).div_ceil(8));
        pass.dispatch_workgroups(groups[0], groups[1], 1);
    }
}

//! Points as perspective-correct discs, by compute.
//!
//! Each point stands for a disc on the plane through it that faces the camera; a pixel inside
//! takes the depth of that plane on its own ray. Two phases of 32-bit atomics decide: the
//! nearest depth first, then the lowest index at that depth. The same pass fills the view's
//! buffers and the photographs' depth maps.

use wgpu::util::DeviceExt as _;

use crate::camera::gpu_data::Camera;
use crate::points::{DrawList, PointStore};
use crate::{Gpu, camera};

#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;

/// The radius of the circle around a square pixel: smaller discs may miss every centre.
pub(crate) const MIN_RADIUS_PX: f32 = 0.708;
/// Largest radius of a disc on a view, pixels.
pub(crate) const MAX_RADIUS_PX: f32 = 24.0;
/// Largest radius of a disc on a depth map, texels.
pub(crate) const MAX_MAP_RADIUS_PX: f32 = 12.0;
/// Largest radius of a disc on a depth map, metres.
pub(crate) const MAX_MAP_RADIUS_M: f32 = 0.1;
/// Discs on depth maps lie behind their point by this share of their radius: the surface they
/// stand for may be inclined by up to atan 2.5 = 68° without hiding itself.
pub(crate) const MAP_PUSH: f32 = 2.5;

pub(crate) const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// The shader that draws discs.
pub(crate) fn wgsl() -> String {
    [camera::WGSL, include_str!("splat.wgsl")].concat()
}

/// The shader that looks up the winners.
pub(crate) const RESOLVE_WGSL: &str = include_str!("resolve.wgsl");
/// The shader that empties buffers.
pub(crate) const FILL_WGSL: &str = include_str!("fill.wgsl");

pub(crate) mod gpu_data {
    use crate::camera::gpu_data::Camera;

    /// Mirrors `Job` in splat.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Job {
        pub(crate) camera: Camera,
        pub(crate) phase: u32,
        pub(crate) first_block: u32,
        pub(crate) stride: u32,
        pub(crate) min_radius_px: f32,
        pub(crate) max_radius_px: f32,
        pub(crate) push: f32,
        pub(crate) padding: [u32; 2],
    }

    /// Mirrors `Resolve` in resolve.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Resolve {
        pub(crate) size: [u32; 2],
        pub(crate) first_block: u32,
        pub(crate) end_block: u32,
    }
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct SplatPass {
    splat: wgpu::ComputePipeline,
    resolve: wgpu::ComputePipeline,
    fill: wgpu::ComputePipeline,
    /// Stands in for indices where only depth is wanted.
    no_indices: wgpu::Buffer,
}

/// The buffers of a view, one word a pixel, and the texture of winning points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewTarget<'a> {
    pub(crate) depths: &'a wgpu::Buffer,
    pub(crate) indices: &'a wgpu::Buffer,
    pub(crate) winners: &'a wgpu::TextureView,
}

/// A draw list on the device.
struct Uploaded {
    blocks: wgpu::Buffer,
    placements: wgpu::Buffer,
}

impl SplatPass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let pipeline = |label, source: String| {
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self {
            splat: pipeline("splat", wgsl()),
            resolve: pipeline("resolve", RESOLVE_WGSL.to_owned()),
            fill: pipeline("fill", FILL_WGSL.to_owned()),
            no_indices: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("no indices"),
                size: 4,
                usage: wgpu::BufferUsages::STORAGE,
                mapped_at_creation: false,
            }),
        }
    }

    /// Draws `list` into a view: afterwards `indices` tells where a point is seen, and
    /// `winners` which.
    pub(crate) fn draw_view(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        store: &PointStore,
        list: &DrawList,
        camera: &Camera,
        target: ViewTarget<'_>,
    ) {
        self.clear(gpu, encoder, target.depths.as_entire_buffer_binding());
        self.clear(gpu, encoder, target.indices.as_entire_buffer_binding());
        let Some(uploaded) = Uploaded::new(gpu, list) else { return };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for phase in [0, 1] {
            for (page, blocks) in &list.pages {
                let job = gpu_data::Job {
                    camera: *camera,
                    phase,
                    first_block: blocks.start,
                    stride: camera.size[0],
                    min_radius_px: MIN_RADIUS_PX,
                    max_radius_px: MAX_RADIUS_PX,
                    push: 0.0,
                    padding: [0; 2],
                };
                let depths = target.depths.as_entire_buffer_binding();
                let page = store.page(*page);
                self.dispatch(
                    gpu,
                    &mut pass,
                    &job,
                    page,
                    &uploaded,
                    depths,
                    target.indices,
                    blocks.len(),
                );
            }
        }
        pass.set_pipeline(&self.resolve);
        for (page, blocks) in &list.pages {
            let uniform = uniform(
                gpu,
                &gpu_data::Resolve {
                    size: camera.size,
                    first_block: blocks.start,
                    end_block: blocks.end,
                },
            );
            let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("resolve"),
                layout: &self.resolve.get_bind_group_layout(0),
                entries: &[
                    entry(0, uniform.as_entire_binding()),
                    entry(1, store.page(*page).as_entire_binding()),
                    entry(2, uploaded.blocks.as_entire_binding()),
                    entry(3, uploaded.placements.as_entire_binding()),
                    entry(4, target.indices.as_entire_binding()),
                    entry(5, wgpu::BindingResource::TextureView(target.winners)),
                ],
            });
            pass.set_bind_group(0, &bind_group, &[]);
            let [width, height] = camera.size;
            pass.dispatch_workgroups(width.div_ceil(16), height.div_ceil(16), 1);
        }
    }

    /// Adds `list` to a depth map: `depths` is its slot, of rows of `stride` texels.
    #[expect(clippy::too_many_arguments, reason = "one argument a source and target")]
    pub(crate) fn draw_depth(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        store: &PointStore,
        list: &DrawList,
        camera: &Camera,
        depths: &wgpu::BufferBinding<'_>,
        stride: u32,
    ) {
        let Some(uploaded) = Uploaded::new(gpu, list) else { return };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for (page, blocks) in &list.pages {
            let job = gpu_data::Job {
                camera: *camera,
                phase: 0,
                first_block: blocks.start,
                stride,
                min_radius_px: MIN_RADIUS_PX,
                max_radius_px: MAX_MAP_RADIUS_PX,
                push: MAP_PUSH,
                padding: [0; 2],
            };
            let page = store.page(*page);
            let depths = depths.clone();
            self.dispatch(
                gpu,
                &mut pass,
                &job,
                page,
                &uploaded,
                depths,
                &self.no_indices,
                blocks.len(),
            );
        }
    }

    /// Sets every word to "nothing here".
    pub(crate) fn clear(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        words: wgpu::BufferBinding<'_>,
    ) {
        let bytes = words.size.map_or(words.buffer.size(), std::num::NonZero::get);
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("fill"),
            layout: &self.fill.get_bind_group_layout(0),
            entries: &[entry(0, wgpu::BindingResource::Buffer(words))],
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.fill);
        pass.set_bind_group(0, &bind_group, &[]);
        // A row of workgroups has a limit of 65535.
        let groups = u32::try_from(bytes.div_ceil(4 * 256)).unwrap_or(u32::MAX);
        let columns = groups.clamp(1, 4096);
        pass.dispatch_workgroups(columns, groups.div_ceil(columns), 1);
    }

    #[expect(clippy::too_many_arguments, reason = "one argument a binding")]
    fn dispatch(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        job: &gpu_data::Job,
        points: &wgpu::Buffer,
        uploaded: &Uploaded,
        depths: wgpu::BufferBinding<'_>,
        indices: &wgpu::Buffer,
        blocks: usize,
    ) {
        let uniform = uniform(gpu, job);
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("splat"),
            layout: &self.splat.get_bind_group_layout(0),
            entries: &[
                entry(0, uniform.as_entire_binding()),
                entry(1, points.as_entire_binding()),
                entry(2, uploaded.blocks.as_entire_binding()),
                entry(3, uploaded.placements.as_entire_binding()),
                entry(4, wgpu::BindingResource::Buffer(depths)),
                entry(5, indices.as_entire_binding()),
            ],
        });
        pass.set_pipeline(&self.splat);
        pass.set_bind_group(0, &bind_group, &[]);
        // A page has at most 8192 blocks, far below the limit of a row of workgroups.
        pass.dispatch_workgroups(blocks as u32, 1, 1);
    }
}

impl Uploaded {
    /// `None` for an empty list: buffers cannot be empty.
    fn new(gpu: &Gpu, list: &DrawList) -> Option<Self> {
        let buffer = |contents: &[u8]| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("point draw list"),
                contents,
                usage: wgpu::BufferUsages::STORAGE,
            })
        };
        (!list.blocks.is_empty()).then(|| Self {
            blocks: buffer(bytemuck::cast_slice(&list.blocks)),
            placements: buffer(bytemuck::cast_slice(&list.placements)),
        })
    }
}

fn uniform<T: bytemuck::Pod>(gpu: &Gpu, data: &T) -> wgpu::Buffer {
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("splat uniform"),
        contents: bytemuck::bytes_of(data),
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

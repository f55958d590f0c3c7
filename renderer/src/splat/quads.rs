//! Large discs as instanced quads.
//!
//! A disc of many pixels would keep one thread busy while its neighbours wait. The compute
//! pass puts such discs on a list instead, as they are, and draws those that find no room
//! there; fragments then offer the same depths to the same pixels.

use glam::UVec2;
use wgpu::util::DeviceExt as _;

use super::{Nearest, Route, quads_wgsl};
use crate::Gpu;
use crate::bindings::bind_group_at;

/// Most discs on the list: 4 MiB.
const CAPACITY: u64 = 1 << 16;
/// Vertices, instances, first vertex, first instance.
const ARGUMENTS: [u32; 4] = [4, 0, 0, 0];
/// Nothing is written to it, but a render pass must have a target.
const CANVAS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

pub(crate) mod gpu_data {
    /// Mirrors `Large` in large.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Large {
        pub(crate) middle_slope: [f32; 4],
        pub(crate) lift_depth_behind: [f32; 4],
        pub(crate) low_high: [f32; 4],
        pub(crate) conic_index: [u32; 4],
    }
}

/// The list of large discs, and the pipelines that draw it.
#[derive(Debug)]
pub(crate) struct Quads {
    arguments: wgpu::Buffer,
    list: wgpu::Buffer,
    atomic_32: wgpu::RenderPipeline,
    atomic_64: Option<wgpu::RenderPipeline>,
}

impl Quads {
    /// With a list of at most `most` bytes.
    pub(crate) fn new(gpu: &Gpu, most: u64) -> Self {
        let disc_bytes = size_of::<gpu_data::Large>() as u64;
        let list = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("large discs"),
            size: (most / disc_bytes).clamp(1, CAPACITY) * disc_bytes,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let arguments = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("large discs"),
            contents: bytemuck::cast_slice(&ARGUMENTS),
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::INDIRECT
                | wgpu::BufferUsages::COPY_DST,
        });
        Self {
            arguments,
            list,
            atomic_32: pipeline(gpu, Route::Atomic32),
            atomic_64: gpu.has_64_bit_atomics().then(|| pipeline(gpu, Route::Atomic64)),
        }
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.list.size() + self.arguments.size()
    }

    /// What the compute pass writes, bound from 6 on.
    pub(super) fn bindings(&self) -> [(u32, wgpu::BindingResource<'_>); 2] {
        [(6, self.arguments.as_entire_binding()), (7, self.list.as_entire_binding())]
    }

    /// Empties the list.
    pub(super) fn reset(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.arguments, 4, Some(4));
    }

    /// Draws the list; `job` is any of its phase.
    pub(super) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        job: wgpu::BufferBinding<'_>,
        nearest: &Nearest,
        canvas: &wgpu::TextureView,
    ) {
        let pipeline = match (nearest.route(), &self.atomic_64) {
            (Route::Atomic64, Some(pipeline)) => pipeline,
            _ => &self.atomic_32,
        };
        let mut resources =
            vec![(0, wgpu::BindingResource::Buffer(job)), (7, self.list.as_entire_binding())];
        resources
            .extend((3..).zip(nearest.bindings().into_iter().map(wgpu::BindingResource::Buffer)));
        let layout = pipeline.get_bind_group_layout(0);
        let group = bind_group_at(gpu, "large discs", &layout, resources);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("large discs"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: canvas,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw_indirect(&self.arguments, 0);
    }
}

/// What quads are drawn on, of a view's size.
pub(crate) fn canvas(gpu: &Gpu, size: UVec2) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("large discs"),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: CANVAS_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn pipeline(gpu: &Gpu, route: Route) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("large discs"),
        source: wgpu::ShaderSource::Wgsl(quads_wgsl(route).into()),
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("large discs"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            ..Default::default()
        },
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: CANVAS_FORMAT,
                blend: None,
                write_mask: wgpu::ColorWrites::empty(),
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

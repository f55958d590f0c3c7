//! From the indices that won to the points they stand for.

use wgpu::util::DeviceExt as _;

use super::{DRAWN_WGSL, ViewTarget};
use crate::Gpu;
use crate::bindings::bind_group;
use crate::points::{DrawList, PointStore};
use crate::screen::VIEWPORT_WGSL;
use crate::settings::SplatNormals;

/// Position relative to the eye as three f32, and the point's code; 0 where no point is seen.
pub(crate) const WINNERS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
/// Octahedral code of the point's normal, 0 where it has none.
pub(crate) const WINNING_NORMALS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// The shader that looks up the winners.
pub(crate) fn wgsl(normals: SplatNormals) -> String {
    let winner = match normals {
        SplatNormals::Eye => include_str!("winner_eye.wgsl"),
        SplatNormals::Estimated => include_str!("winner_estimated.wgsl"),
    };
    [winner, DRAWN_WGSL, VIEWPORT_WGSL, include_str!("resolve.wgsl")].concat()
}

pub(crate) mod gpu_data {
    /// Mirrors `Page` in resolve.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Page {
        pub(crate) width: u32,
        pub(crate) stride: u32,
        pub(crate) first_block: u32,
        pub(crate) end_block: u32,
    }
}

/// The pipeline that looks up winners.
#[derive(Debug)]
pub(crate) struct Resolve {
    pipeline: wgpu::RenderPipeline,
    normals: SplatNormals,
}

impl Resolve {
    pub(crate) fn new(gpu: &Gpu, normals: SplatNormals) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("resolve"),
            source: wgpu::ShaderSource::Wgsl(wgsl(normals).into()),
        });
        let formats = [Some(WINNERS_FORMAT.into()), Some(WINNING_NORMALS_FORMAT.into())];
        let targets = match normals {
            SplatNormals::Eye => &formats[..1],
            SplatNormals::Estimated => &formats[..],
        };
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("resolve"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vs"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fs"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets,
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline, normals }
    }

    /// Fills the winners of a view whose nearest points are known; `lists` are the device's
    /// blocks and placements of `list`, none where it is empty.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        store: &PointStore,
        list: &DrawList,
        lists: Option<(&wgpu::Buffer, &wgpu::Buffer)>,
        target: ViewTarget<'_>,
    ) {
        let attachments = [target.winners, target.winning_normals].map(|view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("resolve"),
            color_attachments: match self.normals {
                SplatNormals::Eye => &attachments[..1],
                SplatNormals::Estimated => &attachments[..],
            },
            ..Default::default()
        });
        let Some((blocks_buffer, placements)) = lists else { return };
        pass.set_pipeline(&self.pipeline);
        let (indices, stride) = target.nearest.indices();
        for (page, blocks) in &list.pages {
            let (points, normals) = store.page(*page);
            let uniform = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("resolve"),
                contents: bytemuck::bytes_of(&gpu_data::Page {
                    width: target.winners.texture().width(),
                    stride,
                    first_block: blocks.start,
                    end_block: blocks.end,
                }),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let mut resources = vec![
                uniform.as_entire_binding(),
                points.as_entire_binding(),
                blocks_buffer.as_entire_binding(),
                placements.as_entire_binding(),
                wgpu::BindingResource::Buffer(indices.clone()),
            ];
            resources.extend(normals.map(wgpu::Buffer::as_entire_binding));
            let layout = self.pipeline.get_bind_group_layout(0);
            let group = bind_group(gpu, "resolve", &layout, resources);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

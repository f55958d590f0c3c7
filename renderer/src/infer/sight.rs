//! What the photographs show at the hypotheses: one pass a rig, its cameras ranked by the depth
//! test.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::Evidence;
use super::grid::{RANK_FORMAT, SIGHT_FORMAT};
use crate::Gpu;
use crate::bindings::{bind_group, bind_group_at};
use crate::screen::Region;
use crate::shade::photograph::{Drawn, Kind};
use crate::shade::{self, PhotographUniforms, atlas_groups};
use crate::tiles::{TILE_ATTRIBUTE, TileLists};

#[derive(Debug)]
pub(crate) struct SightPass {
    module: wgpu::ShaderModule,
    layouts: [wgpu::BindGroupLayout; 3],
    unfiltered: wgpu::Sampler,
    /// One a kind of photograph, made when first needed.
    pipelines: Mutex<BTreeMap<Kind, wgpu::RenderPipeline>>,
}

/// What is drawn in one pass.
#[derive(Debug)]
pub(crate) struct Sights<'a> {
    /// What rigs show.
    pub(crate) shown: &'a wgpu::TextureView,
    pub(crate) ranks: &'a wgpu::TextureView,
    pub(crate) parts: Vec<Part<'a>>,
}

/// What one rig shows.
#[derive(Debug)]
pub(crate) struct Part<'a> {
    /// Which, of those that can see something of the view.
    pub(crate) rig: usize,
    /// Where in the texture.
    pub(crate) region: Option<Region>,
    /// What is read beside the photographs: of the first group, from binding 0, without the sampler,
    /// which is the ninth.
    pub(crate) inputs: Vec<(u32, wgpu::BindingResource<'a>)>,
}

/// To be put before the shaders that compare photographs.
pub(crate) const BRIGHTNESS_WGSL: &str = include_str!("brightness.wgsl");

/// The shader.
pub(super) fn wgsl() -> String {
    let sight = include_str!("sight.wgsl");
    [&shade::colour_wgsl(), shade::TILE_WGSL, BRIGHTNESS_WGSL, super::INFERENCE_WGSL, sight]
        .concat()
}

impl SightPass {
    /// `wgsl` has the entry points `tile` and `fs`, and reads `inputs` beside the sampler.
    pub(crate) fn new(gpu: &Gpu, wgsl: &str, inputs: &[(u32, wgpu::BindingType)]) -> Self {
        Self {
            module: gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("sight"),
                source: wgpu::ShaderSource::Wgsl(wgsl.into()),
            }),
            layouts: layouts(gpu, inputs),
            unfiltered: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()),
            pipelines: Mutex::default(),
        }
    }

    /// Draws what rigs show, each of whose photographs over the tiles in `tiles`.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        evidence: Evidence<'_>,
        tiles: &TileLists,
        sights: Sights<'_>,
    ) {
        let Evidence { photographs, atlas, .. } = evidence;
        let [frame_layout, photograph_layout, atlas_layout] = &self.layouts;
        let uniforms = PhotographUniforms::new(gpu, photographs);
        let atlases = atlas_groups(gpu, atlas_layout, atlas);
        let mut pipelines = self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        let numbered: Vec<(u32, &Drawn)> = (0..).zip(photographs).collect();
        let rigs: Vec<&[(u32, &Drawn)]> =
            numbered.chunk_by(|(_, a), (_, b)| a.rig == b.rig).collect();
        let Sights { shown, ranks, parts } = sights;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("sight"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: shown,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: ranks,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        for Part { rig, region, inputs } in parts {
            if let Some(region) = region {
                region.set(&mut pass);
            }
            let unfiltered = (8, wgpu::BindingResource::Sampler(&self.unfiltered));
            let inputs = inputs.into_iter().chain([unfiltered]);
            pass.set_bind_group(0, &bind_group_at(gpu, "sight", frame_layout, inputs), &[]);
            for (index, drawn) in rigs.get(rig).copied().unwrap_or_default() {
                let kind = drawn.kind;
                let pipeline = pipelines.entry(kind).or_insert_with(|| self.pipeline(gpu, kind));
                pass.set_pipeline(pipeline);
                let photograph = [uniforms.of(*index as usize)];
                let photograph = bind_group(gpu, "sight", photograph_layout, photograph);
                pass.set_bind_group(1, &photograph, &[]);
                pass.set_bind_group(2, &atlases[drawn.atlas], &[]);
                tiles.draw(&mut pass, *index, false);
            }
        }
    }

    fn pipeline(&self, gpu: &Gpu, kind: Kind) -> wgpu::RenderPipeline {
        let constants = kind.constants();
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("sight"),
            bind_group_layouts: &self.layouts.each_ref().map(Some),
            immediate_size: 0,
        });
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("sight"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("tile"),
                compilation_options: compilation_options.clone(),
                buffers: &[Some(TILE_ATTRIBUTE)],
            },
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::TriangleStrip,
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: RANK_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("fs"),
                compilation_options,
                targets: &[Some(SIGHT_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A uniform buffer.
pub(crate) const UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};

/// Records of a picture.
pub(crate) const RECORDS: wgpu::BindingType =
    texture_of(wgpu::TextureSampleType::Uint, wgpu::TextureViewDimension::D2);

/// A texture that is read texel by texel.
pub(crate) const fn texture_of(
    sample_type: wgpu::TextureSampleType,
    view_dimension: wgpu::TextureViewDimension,
) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

fn layouts(gpu: &Gpu, inputs: &[(u32, wgpu::BindingType)]) -> [wgpu::BindGroupLayout; 3] {
    let layout = |entries: &[wgpu::BindGroupLayoutEntry]| {
        gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("sight"),
            entries,
        })
    };
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty,
        count: None,
    };
    let unfiltered = (8, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering));
    let inputs = inputs.iter().copied().chain([unfiltered]);
    let inputs: Vec<_> = inputs.map(|(binding, ty)| entry(binding, ty)).collect();
    let photograph = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let atlas = texture_of(wgpu::TextureSampleType::Uint, wgpu::TextureViewDimension::D2Array);
    [layout(&inputs), layout(&[entry(0, photograph)]), layout(&[entry(0, atlas)])]
}

//! The pipelines that draw photographs, one set for each kind of photograph and way of texturing.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::photograph::{Drawn, Kind};
use super::{CHOICE_FORMAT, Sources, choose_wgsl, deferred_wgsl};
use crate::forward::Sprites;
use crate::tiles::TILE_ATTRIBUTE;
use crate::{Gpu, Texturing};

/// What tells pipelines apart: constants of their shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    kind: Kind,
    /// Whether the photograph is displaced to agree with another.
    aligned: bool,
    texturing: Texturing,
    /// Whether nearer rigs have spoken before.
    of_rest: bool,
}

impl Key {
    pub(super) fn of(drawn: &Drawn, sources: Sources<'_>, of_rest: bool) -> Self {
        Self {
            kind: drawn.kind,
            aligned: drawn.data.shift != 0.0,
            texturing: sources.sprites.map_or(Texturing::Deferred, |sprites| sprites.texturing),
            of_rest,
        }
    }
}

/// Everything that draws photographs, made when first needed.
#[derive(Debug)]
pub(super) struct PhotographPipelines {
    pub(super) layouts: Layouts,
    choose: wgpu::ShaderModule,
    colour: wgpu::ShaderModule,
    blend_format: wgpu::TextureFormat,
    made: Mutex<BTreeMap<Key, Pipelines>>,
}

/// What the bindings of these pipelines are.
#[derive(Debug)]
pub(super) struct Layouts {
    pub(super) frame: wgpu::BindGroupLayout,
    pub(super) photograph: wgpu::BindGroupLayout,
    pub(super) atlas: wgpu::BindGroupLayout,
}

/// Those of one kind of photograph and way of texturing.
#[derive(Clone, Debug)]
pub(super) struct Pipelines {
    pub(super) choose: wgpu::RenderPipeline,
    pub(super) chosen: wgpu::RenderPipeline,
    pub(super) alone: wgpu::RenderPipeline,
    pub(super) sprites: Option<wgpu::RenderPipeline>,
}

impl PhotographPipelines {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let module = |label, source: String| {
            gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        };
        Self {
            layouts: Layouts::new(gpu),
            choose: module("choose", choose_wgsl()),
            colour: module("colour", deferred_wgsl()),
            blend_format: blend_format(gpu),
            made: Mutex::default(),
        }
    }

    /// Those that `photographs` of `sources` are drawn with.
    pub(super) fn all(
        &self,
        gpu: &Gpu,
        sources: Sources<'_>,
        photographs: &[Drawn],
        of_rest: bool,
    ) -> BTreeMap<Key, Pipelines> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        for drawn in photographs {
            let key = Key::of(drawn, sources, of_rest);
            made.entry(key).or_insert_with(|| self.pipelines_of(gpu, key, sources.sprites));
        }
        made.clone()
    }

    fn pipelines_of(&self, gpu: &Gpu, key: Key, sprites: Option<&Sprites<'_>>) -> Pipelines {
        let [lens, masked] = key.kind.constants();
        let aligned = ("ALIGNED", f64::from(u8::from(key.aligned)));
        let points_apart = ("POINTS_APART", f64::from(u8::from(sprites.is_some())));
        let of_rest = ("OF_REST", f64::from(u8::from(key.of_rest)));
        let Layouts { frame, photograph, atlas } = &self.layouts;
        let layout = |label, groups: &[Option<&wgpu::BindGroupLayout>]| {
            gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let tiles = [Some(TILE_ATTRIBUTE)];
        let choose = layout("choose", &[Some(frame), Some(photograph)]);
        let colour = layout("colour", &[Some(frame), Some(photograph), Some(atlas)]);
        let chosen = wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::Equal,
            ..wgpu::StencilFaceState::IGNORE
        };
        // Depths say where it is of use to ask the rest.
        let compare = if key.of_rest {
            wgpu::CompareFunction::Greater
        } else {
            wgpu::CompareFunction::Always
        };
        let adding = |kind: PipelineKind<'_>, constants: &[(&str, f64)], compare, stencil| {
            let add = wgpu::BlendComponent {
                src_factor: wgpu::BlendFactor::One,
                dst_factor: wgpu::BlendFactor::One,
                operation: wgpu::BlendOperation::Add,
            };
            pipeline(
                gpu,
                kind,
                constants,
                wgpu::ColorTargetState {
                    format: self.blend_format,
                    blend: Some(wgpu::BlendState { color: add, alpha: add }),
                    write_mask: wgpu::ColorWrites::ALL,
                },
                depth_stencil(false, compare, stencil),
            )
        };
        let kind = |label, layout, module| PipelineKind {
            label,
            layout: Some(layout),
            buffers: &tiles,
            ..PipelineKind::of(module)
        };
        Pipelines {
            choose: pipeline(
                gpu,
                kind("choose", &choose, &self.choose),
                &[lens],
                wgpu::ColorTargetState {
                    format: self.blend_format,
                    blend: None,
                    write_mask: wgpu::ColorWrites::empty(),
                },
                depth_stencil(true, wgpu::CompareFunction::Greater, replace_always()),
            ),
            chosen: adding(
                kind("chosen", &colour, &self.colour),
                &[lens, masked, points_apart, aligned, of_rest],
                wgpu::CompareFunction::Always,
                chosen,
            ),
            alone: adding(
                kind("alone", &colour, &self.colour),
                &[lens, masked, points_apart, aligned, of_rest],
                compare,
                wgpu::StencilFaceState::IGNORE,
            ),
            sprites: sprites.map(|sprites| {
                let groups = [frame, photograph, atlas, sprites.layout].map(Some);
                let kind = PipelineKind {
                    label: "sprites",
                    layout: Some(&layout("sprites", &groups)),
                    entry_points: ["sprite_vs", "sprite_fs"],
                    ..PipelineKind::of(sprites.module)
                };
                adding(kind, &[lens, masked, of_rest], wgpu::CompareFunction::Always, chosen)
            }),
        }
    }
}

/// The format in which colours are added up: the finest that the device can add in.
pub(crate) fn blend_format(gpu: &Gpu) -> wgpu::TextureFormat {
    if gpu.device.features().contains(wgpu::Features::FLOAT32_BLENDABLE) {
        wgpu::TextureFormat::Rgba32Float
    } else {
        wgpu::TextureFormat::Rgba16Float
    }
}

impl Layouts {
    fn new(gpu: &Gpu) -> Self {
        use wgpu::TextureSampleType::{Float, Uint};
        use wgpu::TextureViewDimension::{D2, D2Array};
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        };
        let texture = |sample_type, view_dimension| wgpu::BindingType::Texture {
            sample_type,
            view_dimension,
            multisampled: false,
        };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let map = texture(Float { filterable: false }, D2Array);
        Self {
            frame: layout(
                "frame",
                &[
                    entry(0, uniform),
                    entry(1, texture(Uint, D2)),
                    entry(2, texture(Uint, D2)),
                    entry(3, map),
                    entry(4, map),
                    entry(5, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
                    entry(6, texture(Float { filterable: true }, D2)),
                    entry(7, texture(Float { filterable: false }, D2)),
                    entry(8, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering)),
                ],
            ),
            photograph: layout("photograph", &[entry(0, uniform)]),
            atlas: layout("atlas", &[entry(0, texture(Uint, D2Array))]),
        }
    }
}

#[derive(Clone, Copy)]
struct PipelineKind<'a> {
    label: &'static str,
    layout: Option<&'a wgpu::PipelineLayout>,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    module: &'a wgpu::ShaderModule,
    /// Of vertices and of fragments.
    entry_points: [&'static str; 2],
}

impl<'a> PipelineKind<'a> {
    fn of(module: &'a wgpu::ShaderModule) -> Self {
        Self { label: "", layout: None, buffers: &[], module, entry_points: ["vs", "fs"] }
    }
}

fn pipeline(
    gpu: &Gpu,
    kind: PipelineKind<'_>,
    constants: &[(&str, f64)],
    target: wgpu::ColorTargetState,
    depth_stencil: wgpu::DepthStencilState,
) -> wgpu::RenderPipeline {
    let compilation_options = wgpu::PipelineCompilationOptions { constants, ..Default::default() };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(kind.label),
        layout: kind.layout,
        vertex: wgpu::VertexState {
            module: kind.module,
            entry_point: Some(kind.entry_points[0]),
            compilation_options: compilation_options.clone(),
            buffers: kind.buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            ..Default::default()
        },
        depth_stencil: Some(depth_stencil),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: kind.module,
            entry_point: Some(kind.entry_points[1]),
            compilation_options,
            targets: &[Some(target)],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// The stencil takes the reference wherever the depth test passes.
fn replace_always() -> wgpu::StencilFaceState {
    wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Always,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op: wgpu::StencilOperation::Replace,
    }
}

fn depth_stencil(
    writes: bool,
    compare: wgpu::CompareFunction,
    face: wgpu::StencilFaceState,
) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: CHOICE_FORMAT,
        depth_write_enabled: Some(writes),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState {
            front: face,
            back: face,
            read_mask: 0xff,
            write_mask: if writes { 0xff } else { 0 },
        },
        bias: wgpu::DepthBiasState::default(),
    }
}

//! Passes that run once for each pixel of a picture.
//!
//! They are fragment shaders over one large triangle rather than compute shaders: what they
//! write goes through the device's output stage, which software devices do many pixels at a
//! time.

use glam::UVec2;

use crate::Gpu;
use crate::bindings::{Bindings, bind_group};

/// A triangle over the whole viewport as `vs`, to be put before the shaders of such passes.
pub(crate) const WHOLE_WGSL: &str =
    concat!(include_str!("viewport.wgsl"), include_str!("screen.wgsl"));
/// The same for shaders with a `vs` of their own.
pub(crate) const VIEWPORT_WGSL: &str = include_str!("viewport.wgsl");

const CLEAR: wgpu::LoadOp<wgpu::Color> = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);

/// A part of a target, texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    pub(crate) origin: UVec2,
    pub(crate) size: UVec2,
}

impl Region {
    /// Has what follows drawn there alone.
    pub(crate) fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        let ([x, y], [width, height]) = (self.origin.to_array(), self.size.to_array());
        pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(x, y, width, height);
    }
}

/// What a pass has to do with marks, depths of 0 or 1 beside what it draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Marks {
    /// Its shader leaves one for each pixel.
    Leaves,
    /// It draws where they are 0, and leaves the rest as it is.
    Heeds,
}

/// Of marks.
pub(crate) const MARKS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A pipeline with the entry points `vs` and `fs`.
#[derive(Debug)]
pub(crate) struct ScreenPass {
    label: &'static str,
    pipeline: wgpu::RenderPipeline,
}

/// The pass of `wgsl`, which writes targets of `formats`.
pub(crate) fn screen_pass(
    gpu: &Gpu,
    label: &'static str,
    wgsl: &str,
    formats: &[wgpu::TextureFormat],
) -> ScreenPass {
    screen_pass_with(gpu, label, wgsl, formats, &[])
}

/// The same, with values for its override constants.
pub(crate) fn screen_pass_with(
    gpu: &Gpu,
    label: &'static str,
    wgsl: &str,
    formats: &[wgpu::TextureFormat],
    constants: &[(&str, f64)],
) -> ScreenPass {
    let wgsl = wgpu::ShaderSource::Wgsl(wgsl.into());
    let pipeline = pipeline(&gpu.device, label, wgsl, formats, constants, None);
    ScreenPass { label, pipeline }
}

/// The same with marks.
pub(crate) fn marked_pass(
    gpu: &Gpu,
    label: &'static str,
    wgsl: &str,
    formats: &[wgpu::TextureFormat],
    constants: &[(&str, f64)],
    marks: Marks,
) -> ScreenPass {
    let wgsl = wgpu::ShaderSource::Wgsl(wgsl.into());
    let pipeline = pipeline(&gpu.device, label, wgsl, formats, constants, Some(marks));
    ScreenPass { label, pipeline }
}

/// The pipeline of a shader that draws over the whole of its targets, of `formats`, on any device: its
/// `fs` runs once for each pixel. The shader needs no `vs`. Bindings are those that it names.
pub fn screen_pipeline(
    device: &wgpu::Device,
    label: &str,
    wgsl: &str,
    formats: &[wgpu::TextureFormat],
) -> wgpu::RenderPipeline {
    let wgsl = wgpu::ShaderSource::Wgsl([WHOLE_WGSL, wgsl].concat().into());
    pipeline(device, label, wgsl, formats, &[], None)
}

fn pipeline(
    device: &wgpu::Device,
    label: &str,
    source: wgpu::ShaderSource<'_>,
    formats: &[wgpu::TextureFormat],
    constants: &[(&str, f64)],
    marks: Option<Marks>,
) -> wgpu::RenderPipeline {
    let label = Some(label);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    let targets: Vec<_> = formats.iter().map(|&format| Some(format.into())).collect();
    let compilation_options = wgpu::PipelineCompilationOptions { constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs"),
            compilation_options: compilation_options.clone(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: marks.map(|marks| wgpu::DepthStencilState {
            format: MARKS_FORMAT,
            depth_write_enabled: Some(marks == Marks::Leaves),
            // The triangle lies at depth 0, no mark below.
            depth_compare: Some(match marks {
                Marks::Leaves => wgpu::CompareFunction::Always,
                Marks::Heeds => wgpu::CompareFunction::GreaterEqual,
            }),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs"),
            compilation_options,
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

impl ScreenPass {
    /// Fills all of `targets`.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        bindings: Bindings<'_>,
        targets: &[&wgpu::TextureView],
    ) {
        self.draw_layers(gpu, encoder, vec![bindings], targets);
    }

    /// The same for a pass with marks, of [`MARKS_FORMAT`] and of the size of the targets: one that heeds them
    /// fills no more than those.
    pub(crate) fn draw_marked(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        bindings: Bindings<'_>,
        targets: &[&wgpu::TextureView],
        marks: &wgpu::TextureView,
    ) {
        let parts = vec![(None, bindings)];
        self.draw_with(gpu, encoder, parts, targets, wgpu::LoadOp::Load, Some(marks));
    }

    /// Fills all of `targets`, one layer over the other; the first leaves no pixel out. Without any they
    /// are 0.
    pub(crate) fn draw_layers(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        layers: Vec<Bindings<'_>>,
        targets: &[&wgpu::TextureView],
    ) {
        // What is there does not matter, and to clear it first would take time in every frame.
        let load = if layers.is_empty() { CLEAR } else { wgpu::LoadOp::Load };
        let parts = layers.into_iter().map(|bindings| (None, bindings)).collect();
        self.draw_with(gpu, encoder, parts, targets, load, None);
    }

    /// Fills parts of all of `targets`, each with bindings of its own; what is in none is 0.
    pub(crate) fn draw_parts(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        parts: Vec<(Option<Region>, Bindings<'_>)>,
        targets: &[&wgpu::TextureView],
    ) {
        self.draw_with(gpu, encoder, parts, targets, CLEAR, None);
    }

    fn draw_with(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        parts: Vec<(Option<Region>, Bindings<'_>)>,
        targets: &[&wgpu::TextureView],
        load: wgpu::LoadOp<wgpu::Color>,
        marks: Option<&wgpu::TextureView>,
    ) {
        let layout = self.pipeline.get_bind_group_layout(0);
        let attachments: Vec<_> = targets
            .iter()
            .map(|view| {
                Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                })
            })
            .collect();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(self.label),
            color_attachments: &attachments,
            depth_stencil_attachment: marks.map(|view| {
                // A pass that leaves marks leaves all: it need not clear them first.
                let depth_ops =
                    wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
                wgpu::RenderPassDepthStencilAttachment {
                    view,
                    depth_ops: Some(depth_ops),
                    stencil_ops: None,
                }
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        for (region, bindings) in parts {
            if let Some(region) = region {
                region.set(&mut pass);
            }
            pass.set_bind_group(0, &bind_group(gpu, self.label, &layout, bindings), &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

//! What is known of some cells of a grid, spread to all of them, or to those near: push and pull
//! (Gortler et al., The Lumigraph).
//!
//! Equations are in reference.rs.

use glam::UVec2;
use wgpu::util::DeviceExt as _;

use crate::Gpu;
use crate::bindings::{Bindings, bind_group};

mod levels;
pub(crate) mod reference;
#[cfg(test)]
mod tests;

#[cfg(test)]
pub(crate) use levels::FEW_CELLS;
pub(crate) use levels::{Layers, Levels};

/// Threads a side of a workgroup of pull.wgsl and push.wgsl.
const THREADS: u32 = 8;

pub(crate) mod gpu_data {
    /// Mirrors `Coarse` in coarse.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Coarse {
        pub(crate) otherwise: [f32; 3],
        pub(crate) first_left: u32,
    }
}

/// Every shader of this pass, by name, for levels of a format as WGSL names it.
pub(crate) fn sources(format: &str) -> [(&'static str, String); 3] {
    [
        ("pull", include_str!("pull.wgsl")),
        ("push", include_str!("push.wgsl")),
        ("coarse", include_str!("coarse.wgsl")),
    ]
    .map(|(name, wgsl)| (name, wgsl.replace("FORMAT,", &format!("{format},"))))
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct DiffusePass {
    pull: wgpu::ComputePipeline,
    push: wgpu::ComputePipeline,
    coarse: wgpu::ComputePipeline,
}

impl DiffusePass {
    /// For levels of `format`, four channels of floats.
    pub(crate) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let name =
            if format == wgpu::TextureFormat::Rgba32Float { "rgba32float" } else { "rgba16float" };
        let [pull, push, coarse] = sources(name).map(|(label, wgsl)| {
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(wgsl.into()),
            });
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: None,
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        });
        Self { pull, push, coarse }
    }

    /// Diffuses what is known of each layer; a whole one of which that is nothing is `otherwise`.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        levels: &Levels,
        otherwise: [f32; 3],
    ) {
        let Levels { layers, known, diffused, .. } = levels;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("diffuse"),
            ..Default::default()
        });
        let uniform = |contents: &[u8]| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("diffuse"),
                contents,
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        let texture = wgpu::BindingResource::TextureView;
        for pair in known.windows(2) {
            let bindings = vec![texture(&pair[0]), texture(&pair[1])];
            run(gpu, &mut pass, &self.pull, bindings, groups(&pair[1], layers.count()));
        }
        let coarsest = known.len() - 1;
        let coarse = gpu_data::Coarse { otherwise, first_left: layers.first_left(coarsest) };
        let coarse = uniform(bytemuck::bytes_of(&coarse));
        let bindings = vec![
            texture(&known[coarsest]),
            texture(&diffused[coarsest]),
            coarse.as_entire_binding(),
        ];
        run(gpu, &mut pass, &self.coarse, bindings, [layers.count(), 1, 1]);
        for level in (0..coarsest).rev() {
            let first_left = uniform(bytemuck::bytes_of(&layers.first_left(level)));
            let bindings = vec![
                texture(&known[level]),
                texture(&diffused[level + 1]),
                texture(&diffused[level]),
                first_left.as_entire_binding(),
            ];
            run(gpu, &mut pass, &self.push, bindings, groups(&diffused[level], layers.count()));
        }
    }
}

fn run(
    gpu: &Gpu,
    pass: &mut wgpu::ComputePass<'_>,
    pipeline: &wgpu::ComputePipeline,
    bindings: Bindings<'_>,
    [x, y, z]: [u32; 3],
) {
    let group = bind_group(gpu, "diffuse", &pipeline.get_bind_group_layout(0), bindings);
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(x, y, z);
}

/// Workgroups for every cell of a level.
fn groups(level: &wgpu::TextureView, layers: u32) -> [u32; 3] {
    let size = level.texture().size();
    let UVec2 { x, y } = UVec2::new(size.width, size.height).map(|side| side.div_ceil(THREADS));
    [x, y, layers]
}

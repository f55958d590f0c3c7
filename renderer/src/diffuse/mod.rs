//! What is known of some cells of a grid, spread to all of them: push and pull (Gortler et al.,
//! The Lumigraph).
//!
//! Equations are in reference.rs.

use glam::UVec2;
use wgpu::util::DeviceExt as _;

use crate::screen::{ScreenPass, WHOLE_WGSL, screen_pass};
use crate::{Gpu, memory};

pub(crate) mod reference;
#[cfg(test)]
mod tests;

/// Most cells of the level from which on all others are made at once: software devices take
/// hundreds of microseconds for a pass, however little it does. CELLS in coarse.wgsl.
pub(crate) const FEW_CELLS: u32 = 512;

/// Every shader of this pass, by name.
pub(crate) fn sources() -> [(&'static str, String); 3] {
    let whole = |own: &str| [WHOLE_WGSL, own].concat();
    [
        ("pull", whole(include_str!("pull.wgsl"))),
        ("push", whole(include_str!("push.wgsl"))),
        ("coarse", coarse_wgsl("rgba32float")),
    ]
}

/// The shader of all coarse levels, of this format.
fn coarse_wgsl(format: &str) -> String {
    include_str!("coarse.wgsl").replace("FORMAT,", &format!("{format},"))
}

/// A pyramid of cells, but for the coarsest: what is known of them, and the same made whole.
#[derive(Debug)]
pub(crate) struct Levels {
    /// Finest first, up to three channels times the weight, and in the last the weight, 0 to 1.
    known: Vec<wgpu::TextureView>,
    /// The channels, and in the last 1; 0 where nothing is known of any cell.
    whole: Vec<wgpu::TextureView>,
}

impl Levels {
    /// For so many cells, of four channels of `format`.
    pub(crate) fn new(gpu: &Gpu, cells: UVec2, format: wgpu::TextureFormat) -> Self {
        let all = || sizes(cells).into_iter().map(|size| values(gpu, size, format)).collect();
        Self { known: all(), whole: all() }
    }

    /// What [`Levels::bytes`] is for so many cells.
    pub(crate) fn bytes_for(cells: UVec2, format: wgpu::TextureFormat) -> u64 {
        sizes(cells).into_iter().map(|size| 2 * memory::of_texels(format, size, 1)).sum()
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        let views = self.known.iter().chain(&self.whole);
        views.map(|view| memory::of_texture(view.texture())).sum()
    }

    /// To be drawn into: up to three channels times the weight, and in the last the weight, 0 to 1.
    pub(crate) fn known(&self) -> &wgpu::TextureView {
        &self.known[0]
    }

    /// The channels of every cell, and in the last 1; 0 where nothing is known of any.
    pub(crate) fn whole(&self) -> &wgpu::TextureView {
        &self.whole[0]
    }
}

/// What is known of the cells of a grid, and of those beside.
#[derive(Debug)]
pub(crate) struct Near {
    known: wgpu::TextureView,
    coarser: wgpu::TextureView,
    spread: wgpu::TextureView,
}

impl Near {
    /// For so many cells, of four channels of `format`.
    pub(crate) fn new(gpu: &Gpu, cells: UVec2, format: wgpu::TextureFormat) -> Self {
        let [known, coarser, spread] =
            [cells, halved(cells), cells].map(|size| values(gpu, size, format));
        Self { known, coarser, spread }
    }

    /// What [`Near::bytes`] is for so many cells.
    pub(crate) fn bytes_for(cells: UVec2, format: wgpu::TextureFormat) -> u64 {
        [cells, halved(cells), cells].map(|size| memory::of_texels(format, size, 1)).iter().sum()
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        [&self.known, &self.coarser, &self.spread]
            .map(|view| memory::of_texture(view.texture()))
            .iter()
            .sum()
    }

    /// To be drawn into, as [`Levels::known`].
    pub(crate) fn known(&self) -> &wgpu::TextureView {
        &self.known
    }

    /// The channels times the weight, and in the last the weight: 1 where something is known, and less beside.
    pub(crate) fn spread(&self) -> &wgpu::TextureView {
        &self.spread
    }
}

/// A texture for a level.
fn values(gpu: &Gpu, size: UVec2, format: wgpu::TextureFormat) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("diffuse"),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

/// Cells of the next coarser level.
fn halved(size: UVec2) -> UVec2 {
    (size + 1) / 2
}

/// Sizes of a pyramid from `size` down to few cells.
fn sizes(size: UVec2) -> Vec<UVec2> {
    let mut sizes = vec![size];
    while let Some(&size) = sizes.last().filter(|size| size.element_product() > FEW_CELLS) {
        sizes.push(halved(size));
    }
    sizes
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct DiffusePass {
    pull: ScreenPass,
    push: ScreenPass,
    coarse: wgpu::ComputePipeline,
}

impl DiffusePass {
    /// For levels of `format`, four channels of floats.
    pub(crate) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let [pull, push, _] = sources();
        let pass = |(label, wgsl): (_, String)| screen_pass(gpu, label, &wgsl, &[format]);
        let name =
            if format == wgpu::TextureFormat::Rgba32Float { "rgba32float" } else { "rgba16float" };
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("coarse"),
            source: wgpu::ShaderSource::Wgsl(coarse_wgsl(name).into()),
        });
        let coarse = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("coarse"),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { pull: pass(pull), push: pass(push), coarse }
    }

    /// Spreads what is known to the cells beside.
    pub(crate) fn draw_near(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, near: &Near) {
        let texture = wgpu::BindingResource::TextureView;
        let Near { known, coarser, spread } = near;
        self.pull.draw(gpu, encoder, vec![texture(known)], &[coarser]);
        self.push.draw(gpu, encoder, vec![texture(known), texture(coarser)], &[spread]);
    }

    /// Makes whole what is known; where that is nothing, all of it is `otherwise`.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        levels: &Levels,
        otherwise: [f32; 3],
    ) {
        let texture = wgpu::BindingResource::TextureView;
        for pair in levels.known.windows(2) {
            self.pull.draw(gpu, encoder, vec![texture(&pair[0])], &[&pair[1]]);
        }
        let [x, y, z] = otherwise;
        let otherwise = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("diffuse"),
            contents: bytemuck::bytes_of(&[x, y, z, 0.0]),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        if let (Some(known), Some(whole)) = (levels.known.last(), levels.whole.last()) {
            let bindings = [texture(known), texture(whole), otherwise.as_entire_binding()];
            let entries: Vec<_> = bindings
                .into_iter()
                .zip(0..)
                .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
                .collect();
            let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("coarse"),
                layout: &self.coarse.get_bind_group_layout(0),
                entries: &entries,
            });
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.coarse);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
        for (known, pair) in levels.known.iter().zip(levels.whole.windows(2)).rev() {
            self.push.draw(gpu, encoder, vec![texture(known), texture(&pair[1])], &[&pair[0]]);
        }
    }
}

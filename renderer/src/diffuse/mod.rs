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

/// Every shader of this pass, by name.
pub(crate) fn sources() -> [(&'static str, String); 3] {
    [
        ("pull", include_str!("pull.wgsl")),
        ("top", include_str!("top.wgsl")),
        ("push", include_str!("push.wgsl")),
    ]
    .map(|(name, own)| (name, [WHOLE_WGSL, own].concat()))
}

/// A pyramid of cells: what is known of them, and the same made whole.
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
        let view = |size: UVec2| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("diffuse"),
                size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        let all = || sizes(cells).into_iter().map(view).collect();
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

/// Sizes of a pyramid from `size` down to a single texel.
fn sizes(size: UVec2) -> Vec<UVec2> {
    let mut sizes = vec![size];
    while let Some(&size) = sizes.last().filter(|size| size.max_element() > 1) {
        sizes.push((size + 1) / 2);
    }
    sizes
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct DiffusePass {
    pull: ScreenPass,
    top: ScreenPass,
    push: ScreenPass,
}

impl DiffusePass {
    /// For levels of `format`.
    pub(crate) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let [pull, top, push] =
            sources().map(|(label, wgsl)| screen_pass(gpu, label, &wgsl, &[format]));
        Self { pull, top, push }
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
            let bindings = vec![otherwise.as_entire_binding(), texture(known)];
            self.top.draw(gpu, encoder, bindings, &[whole]);
        }
        for (known, pair) in levels.known.iter().zip(levels.whole.windows(2)).rev() {
            self.push.draw(gpu, encoder, vec![texture(known), texture(&pair[1])], &[&pair[0]]);
        }
    }
}

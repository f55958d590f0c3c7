//! The textures of a pyramid.

use glam::UVec2;

use super::reference::NEAR_LEVELS;
use crate::layers::{all_layers, one_layer};
use crate::{Gpu, memory};

/// Most cells of the level from which on all others are made at once: software devices take
/// hundreds of microseconds for a pass, however little it does. CELLS in coarse.wgsl.
pub(crate) const FEW_CELLS: u32 = 512;

/// What is diffused at once over one grid, each a layer of its textures: first what all cells are to
/// have, then what is to stay near the cells that have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layers {
    pub(crate) whole: u32,
    pub(crate) near: u32,
}

impl Layers {
    pub(crate) const fn count(self) -> u32 {
        self.whole + self.near
    }

    /// The layer from which on what a level lacks is left so; the finest is 0.
    pub(super) fn first_left(self, level: usize) -> u32 {
        if level < NEAR_LEVELS { self.count() } else { self.whole }
    }
}

/// A pyramid of cells, but for the coarsest: what is known of them, and the same diffused.
#[derive(Debug)]
pub(crate) struct Levels {
    pub(super) layers: Layers,
    /// Finest first, up to three channels times the weight, and in the last the weight, 0 to 1.
    pub(super) known: Vec<wgpu::TextureView>,
    /// Likewise.
    pub(super) diffused: Vec<wgpu::TextureView>,
    known_layers: Vec<wgpu::TextureView>,
}

impl Levels {
    /// For so many cells, of four channels of `format`.
    pub(crate) fn new(
        gpu: &Gpu,
        cells: UVec2,
        layers: Layers,
        format: wgpu::TextureFormat,
    ) -> Self {
        let values = |size| all_layers(&values(gpu, size, layers.count(), format));
        let sizes = sizes(cells);
        let known: Vec<_> = sizes.iter().copied().map(values).collect();
        let diffused = sizes.into_iter().map(values).collect();
        let known_layers = (0..layers.count()).map(|i| one_layer(known[0].texture(), i)).collect();
        Self { layers, known, diffused, known_layers }
    }

    /// What [`Levels::bytes`] is for so many cells.
    pub(crate) fn bytes_for(cells: UVec2, layers: Layers, format: wgpu::TextureFormat) -> u64 {
        let of = |size| memory::of_texels(format, size, layers.count());
        sizes(cells).into_iter().map(|size| 2 * of(size)).sum()
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        let views = self.known.iter().chain(&self.diffused);
        views.map(|view| memory::of_texture(view.texture())).sum()
    }

    /// One a layer, to be drawn into: up to three channels times the weight, and in the last the weight, 0
    /// to 1.
    pub(crate) fn known_layers(&self) -> &[wgpu::TextureView] {
        &self.known_layers
    }

    /// All layers. Of a whole one: the channels of every cell, and in the last 1; 0 where nothing is known of
    /// any. Of a near one: the channels times the weight, and in the last the weight, 1 where something is
    /// known, less beside, 0 farther away.
    pub(crate) fn diffused(&self) -> &wgpu::TextureView {
        &self.diffused[0]
    }
}

/// A texture for a level.
fn values(gpu: &Gpu, size: UVec2, layers: u32, format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("diffuse"),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    })
}

/// Sizes of a pyramid from `size` down to few cells, and as far as what stays near comes.
fn sizes(size: UVec2) -> Vec<UVec2> {
    let all = std::iter::successors(Some(size), |&size| Some((size + 1) / 2));
    let many = all.clone().take_while(|size| size.element_product() > FEW_CELLS).count();
    all.take(many.max(NEAR_LEVELS) + 1).collect()
}

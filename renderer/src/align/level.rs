//! The textures of one level of the pyramid on which two photographs are aligned.

use glam::UVec2;

use crate::infer::Grid;
use crate::screen::Region;
use crate::{Gpu, memory};

pub(super) const WARPED_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub(super) const FOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub(super) const TWO_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;
pub(super) const SOLVED_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub(super) const DISPLACEMENT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

#[derive(Debug)]
pub(super) struct Level {
    pub(super) grid: Grid,
    /// Where it lies in the [`Sheet`](super::sheet::Sheet).
    pub(super) region: Region,
    pub(super) warped: wgpu::TextureView,
    pub(super) displaced: wgpu::TextureView,
    pub(super) sums: [wgpu::TextureView; 2],
    pub(super) solved: wgpu::TextureView,
    pub(super) smoothed: wgpu::TextureView,
}

impl Level {
    /// What [`Level::bytes`] is for a grid.
    pub(super) fn bytes_for(grid: Grid) -> u64 {
        let of = |format| memory::of_texels(format, grid.cells, 1);
        of(WARPED_FORMAT)
            + 2 * of(DISPLACEMENT_FORMAT)
            + of(FOUR_FORMAT)
            + of(TWO_FORMAT)
            + of(SOLVED_FORMAT)
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let Self { warped, displaced, sums, solved, smoothed, .. } = self;
        let views = [warped, displaced, solved, smoothed].into_iter();
        let views = views.chain(sums);
        views.map(|view| memory::of_texture(view.texture())).sum()
    }

    pub(super) fn new(gpu: &Gpu, grid: Grid, region: Region) -> Self {
        let view = |format| texture(gpu, grid.cells, format);
        Self {
            grid,
            region,
            warped: view(WARPED_FORMAT),
            displaced: view(DISPLACEMENT_FORMAT),
            sums: [view(FOUR_FORMAT), view(TWO_FORMAT)],
            solved: view(SOLVED_FORMAT),
            smoothed: view(DISPLACEMENT_FORMAT),
        }
    }
}

/// A texture that passes draw and read.
pub(super) fn texture(gpu: &Gpu, size: UVec2, format: wgpu::TextureFormat) -> wgpu::TextureView {
    gpu.device
        .create_texture(&wgpu::TextureDescriptor {
            label: Some("align"),
            size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
        .create_view(&Default::default())
}

//! The grid of cells on which depths are inferred, and the textures over it.

use glam::UVec2;

use crate::diffuse::{Layers, Levels};
use crate::layers::{all_layers, one_layer};
use crate::surface::POSITION_FORMAT;
use crate::{Gpu, memory};

/// Pixels a side of the smallest cells.
const MIN_STEP: u32 = 4;
/// Cells of several hypotheses are as large as it takes for this many to cover a picture: of 1024×512
/// pixels those of 8 pixels, which infer as good a picture as those of 4 do in half of the time …
const MAX_CELLS: u32 = 1 << 14;
/// … and those of one depth, which takes less.
const MAX_CELLS_ALONE: u32 = 1 << 16;

pub(crate) const RAY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Of inverse ranges with their weights while they are diffused.
pub(crate) const KNOWN_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub(super) const INVERSE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
pub(crate) const SIGHT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Float;
pub(crate) const RANK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Four hypotheses in a texel.
pub(super) const COST_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Most rigs that are asked about a hypothesis: two must see it, and the nearest need not.
pub(crate) const MAX_RIGS: u32 = 4;

/// How a picture is cut into cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Grid {
    pub(crate) picture: UVec2,
    /// Pixels a side of a cell, a multiple of 4.
    pub(crate) step: u32,
    pub(crate) cells: UVec2,
    /// Hypotheses between the backdrop and the diffused depth.
    pub(crate) between: u32,
    /// All hypotheses of a cell: those, these two, and where there are any between, one nearer.
    pub(crate) hypotheses: u32,
}

impl Grid {
    /// The finest grid over a picture such that all hypotheses, one below the other, make a
    /// texture of at most `max_side`; `None` where there is none.
    pub(crate) fn new(picture: UVec2, between: u32, max_side: u32) -> Option<Self> {
        Self::with(picture, between, between + if between > 0 { 3 } else { 2 }, max_side)
    }

    /// The same with a single depth a cell.
    pub(crate) fn alone(picture: UVec2, max_side: u32) -> Option<Self> {
        Self::with(picture, 0, 1, max_side)
    }

    /// The same picture in cells so many times twice as large.
    pub(crate) fn coarser(self, times: u32) -> Self {
        let step = self.step << times;
        let UVec2 { x, y } = self.picture;
        Self { step, cells: UVec2::new(x.div_ceil(step), y.div_ceil(step)), ..self }
    }

    fn with(picture: UVec2, between: u32, hypotheses: u32, max_side: u32) -> Option<Self> {
        let mut step = MIN_STEP;
        let max_cells = if hypotheses > 1 { MAX_CELLS } else { MAX_CELLS_ALONE };
        while step < max_side {
            let cells = UVec2::new(picture.x.div_ceil(step), picture.y.div_ceil(step));
            if cells.element_product() <= max_cells
                && cells.y.saturating_mul(hypotheses) <= max_side
            {
                return Some(Self { picture, step, cells, between, hypotheses });
            }
            step *= 2;
        }
        None
    }

    /// Four hypotheses in one.
    fn packed(&self) -> UVec2 {
        UVec2::new(self.cells.x, self.cells.y * self.hypotheses.div_ceil(4))
    }

    /// All hypotheses, one below the other.
    pub(super) fn tall(&self) -> UVec2 {
        UVec2::new(self.cells.x, self.cells.y * self.hypotheses)
    }
}

/// Inverse ranges alone are diffused.
const DEPTHS: Layers = Layers { whole: 1, near: 0 };

/// The textures of one grid, kept between frames.
#[derive(Debug)]
pub(super) struct Cells {
    pub(super) grid: Grid,
    pub(super) rays: wgpu::TextureView,
    /// What is known of inverse ranges.
    pub(super) levels: Levels,
    /// And what that says of the others.
    pub(super) diffused: wgpu::TextureView,
    /// Where all hypotheses lie.
    pub(super) places: wgpu::TextureView,
    pub(super) sights: wgpu::TextureView,
    /// Its layers, one a rig.
    pub(super) sight_of_rig: Vec<wgpu::TextureView>,
    pub(super) ranks: wgpu::TextureView,
    pub(super) costs: [wgpu::TextureView; 2],
    pub(super) chosen: wgpu::TextureView,
    pub(super) settled: wgpu::TextureView,
}

impl Cells {
    /// What [`Cells::bytes`] is for a grid.
    pub(super) fn bytes_for(grid: Grid) -> u64 {
        let of = memory::of_texels;
        let inverse = |size| of(INVERSE_FORMAT, size, 1);
        Levels::bytes_for(grid.cells, DEPTHS, KNOWN_FORMAT)
            + of(RAY_FORMAT, grid.cells, 1)
            + of(POSITION_FORMAT, grid.tall(), 1)
            + of(SIGHT_FORMAT, grid.tall(), MAX_RIGS)
            + of(RANK_FORMAT, grid.tall(), 1)
            + 2 * of(COST_FORMAT, grid.packed(), 1)
            + 2 * inverse(grid.cells)
    }

    /// What [`super::Past::bytes`] is for a grid.
    pub(super) fn bytes_of_past(grid: Grid) -> u64 {
        memory::of_texels(INVERSE_FORMAT, grid.cells, 1)
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let Self { rays, levels, places, sights, ranks, costs, chosen, settled, .. } = self;
        let views = [rays, places, sights, ranks, chosen, settled].into_iter().chain(costs);
        levels.bytes() + views.map(|view| memory::of_texture(view.texture())).sum::<u64>()
    }

    pub(super) fn new(gpu: &Gpu, grid: Grid) -> Self {
        let texture = |size, layers, format| texture(gpu, size, layers, format);
        let view = |size, format| texture(size, 1, format).create_view(&Default::default());
        let sights = texture(grid.tall(), MAX_RIGS, SIGHT_FORMAT);
        let levels = Levels::new(gpu, grid.cells, DEPTHS, KNOWN_FORMAT);
        Self {
            grid,
            rays: view(grid.cells, RAY_FORMAT),
            diffused: one_layer(levels.diffused().texture(), 0),
            levels,
            places: view(grid.tall(), POSITION_FORMAT),
            sights: all_layers(&sights),
            sight_of_rig: (0..MAX_RIGS).map(|rig| one_layer(&sights, rig)).collect(),
            ranks: view(grid.tall(), RANK_FORMAT),
            costs: [view(grid.packed(), COST_FORMAT), view(grid.packed(), COST_FORMAT)],
            chosen: view(grid.cells, INVERSE_FORMAT),
            settled: Self::inverses(gpu, grid),
        }
    }

    /// A texture of one inverse range a cell.
    pub(super) fn inverses(gpu: &Gpu, grid: Grid) -> wgpu::TextureView {
        texture(gpu, grid.cells, 1, INVERSE_FORMAT).create_view(&Default::default())
    }
}

fn texture(gpu: &Gpu, size: UVec2, layers: u32, format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("infer"),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

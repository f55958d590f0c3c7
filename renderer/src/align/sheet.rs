//! What both rigs show of all levels, side by side in few textures: one pass over such a sheet takes the place
//! of one for each level and rig, which devices could not do at once.

use glam::UVec2;

use super::level::{WARPED_FORMAT, texture};
use crate::infer::{Grid, RANK_FORMAT, SIGHT_FORMAT};
use crate::screen::Region;
use crate::{Gpu, memory};

#[derive(Debug)]
pub(super) struct Sheet {
    /// Of one rig.
    size: UVec2,
    /// The second rig to the right of the first.
    pub(super) sights: wgpu::TextureView,
    pub(super) ranks: wgpu::TextureView,
    /// Of both, summed along rows.
    pub(super) sums: wgpu::TextureView,
    /// What stands out of its surroundings, of both.
    pub(super) patterns: wgpu::TextureView,
}

impl Sheet {
    /// For levels, the finest first.
    pub(super) fn new(gpu: &Gpu, levels: &[Grid]) -> Self {
        let size = size_of(levels);
        let both = size * UVec2::new(2, 1);
        Self {
            size,
            sights: texture(gpu, both, SIGHT_FORMAT),
            ranks: texture(gpu, both, RANK_FORMAT),
            sums: texture(gpu, size, WARPED_FORMAT),
            patterns: texture(gpu, size, WARPED_FORMAT),
        }
    }

    /// How far to the right of the first the second rig is.
    pub(super) fn across(&self) -> u32 {
        self.size.x
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let Self { sights, ranks, sums, patterns, .. } = self;
        let views = [sights, ranks, sums, patterns];
        views.map(|view| memory::of_texture(view.texture())).iter().sum()
    }

    /// What [`Sheet::bytes`] is for levels.
    pub(super) fn bytes_for(levels: &[Grid]) -> u64 {
        let size = size_of(levels);
        let of = |format, size| memory::of_texels(format, size, 1);
        let both = size * UVec2::new(2, 1);
        of(SIGHT_FORMAT, both) + of(RANK_FORMAT, both) + 2 * of(WARPED_FORMAT, size)
    }
}

/// Where each level lies: the finest at the top, the others below it in a row.
pub(super) fn regions(levels: &[Grid]) -> Vec<Region> {
    let below = levels.first().map_or(0, |finest| finest.cells.y);
    let mut x = 0;
    let place = |(index, grid): (usize, &Grid)| {
        let origin = if index == 0 { UVec2::ZERO } else { UVec2::new(x, below) };
        x += if index == 0 { 0 } else { grid.cells.x };
        Region { origin, size: grid.cells }
    };
    levels.iter().enumerate().map(place).collect()
}

fn size_of(levels: &[Grid]) -> UVec2 {
    let ends = regions(levels).into_iter().map(|region| region.origin + region.size);
    ends.fold(UVec2::ONE, UVec2::max)
}

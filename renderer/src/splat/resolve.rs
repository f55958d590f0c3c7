//! From the indices that won to the points they stand for.

use std::ops::Range;

use wgpu::util::DeviceExt as _;

use super::{DRAWN_WGSL, ViewTarget};
use crate::Gpu;
use crate::bindings::Bindings;
use crate::points::{DrawList, PointStore};
use crate::screen::{ScreenPass, WHOLE_WGSL, screen_pass};
use crate::settings::SplatNormals;

/// Position relative to the eye as three f32, and the point's code; 0 where no point is seen.
pub(crate) const WINNERS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
/// Octahedral code of the point's normal, 0 where it has none.
pub(crate) const WINNING_NORMALS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// The shader that looks up the winners.
pub(crate) fn wgsl(normals: SplatNormals) -> String {
    let winner = match normals {
        SplatNormals::Eye => include_str!("winner_eye.wgsl"),
        SplatNormals::Estimated => include_str!("winner_estimated.wgsl"),
    };
    [winner, DRAWN_WGSL, WHOLE_WGSL, include_str!("resolve.wgsl")].concat()
}

pub(crate) mod gpu_data {
    /// Mirrors `Page` in resolve.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Page {
        pub(crate) width: u32,
        pub(crate) stride: u32,
        pub(crate) first_block: u32,
        pub(crate) end_block: u32,
    }
}

/// The pass that looks up winners.
#[derive(Debug)]
pub(crate) struct Resolve {
    pass: ScreenPass,
    normals: SplatNormals,
}

impl Resolve {
    pub(crate) fn new(gpu: &Gpu, normals: SplatNormals) -> Self {
        let formats = [WINNERS_FORMAT, WINNING_NORMALS_FORMAT];
        let pass = screen_pass(gpu, "resolve", &wgsl(normals), written(&formats, normals));
        Self { pass, normals }
    }

    /// Fills the winners of a view whose nearest points are known; `blocks` are the
    /// device's of `list`, none where it is empty.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        store: &PointStore,
        list: &DrawList,
        blocks: Option<&wgpu::Buffer>,
        target: ViewTarget<'_>,
    ) {
        let (indices, stride) = target.nearest.indices();
        let uniform = |blocks: &Range<u32>| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("resolve"),
                contents: bytemuck::bytes_of(&gpu_data::Page {
                    width: target.winners.texture().width(),
                    stride,
                    first_block: blocks.start,
                    end_block: blocks.end,
                }),
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        let pages: Vec<_> =
            list.pages.iter().map(|(page, blocks)| (store.page(*page), uniform(blocks))).collect();
        let mut layers = Vec::new();
        if let Some(blocks) = blocks {
            for ((points, normals), uniform) in &pages {
                let buffers = [uniform, points, blocks];
                let mut bindings: Bindings<'_> =
                    buffers.map(wgpu::Buffer::as_entire_binding).into();
                bindings.push(wgpu::BindingResource::Buffer(indices.clone()));
                bindings.extend(normals.map(wgpu::Buffer::as_entire_binding));
                layers.push(bindings);
            }
        }
        let targets = [target.winners, target.winning_normals];
        self.pass.draw_layers(gpu, encoder, layers, written(&targets, self.normals));
    }
}

/// Of the winners and their normals what is written: the latter only where points have some.
fn written<T>(both: &[T; 2], normals: SplatNormals) -> &[T] {
    match normals {
        SplatNormals::Eye => &both[..1],
        SplatNormals::Estimated => both,
    }
}

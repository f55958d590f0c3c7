//! Single texels, read back together.

use glam::UVec2;

use crate::targets::read_back;
use crate::{Gpu, RenderError};

/// Bytes between two texels: copies begin at multiples of what the largest takes.
const STRIDE: u64 = 16;
/// Texels that are read at once, at most.
const MOST: u64 = 4096;

/// Texels to be read.
#[derive(Debug)]
pub(crate) struct Texels {
    encoder: wgpu::CommandEncoder,
    buffer: wgpu::Buffer,
    count: u64,
}

/// One of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Texel(u64);

/// What they hold.
#[derive(Debug)]
pub(crate) struct Words(Vec<u8>);

impl Texels {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("texels"),
            size: STRIDE * MOST,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let encoder = gpu.device.create_command_encoder(&Default::default());
        Self { encoder, buffer, count: 0 }
    }

    /// Has the texel at `at` in `layer` of a texture read, of at most four words. It must exist.
    pub(crate) fn one(&mut self, texture: &wgpu::Texture, at: UVec2, layer: u32) -> Texel {
        assert!(self.count < MOST, "as many as are asked for fit");
        let from = wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: at.x, y: at.y, z: layer },
            aspect: wgpu::TextureAspect::All,
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: STRIDE * self.count,
            bytes_per_row: None,
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout };
        self.encoder.copy_texture_to_buffer(from, to, wgpu::Extent3d::default());
        self.count += 1;
        Texel(self.count - 1)
    }

    /// Reads them all.
    pub(crate) fn read(self, gpu: &Gpu) -> Result<Words, RenderError> {
        gpu.queue.submit([self.encoder.finish()]);
        read_back(gpu, &self.buffer).map(Words)
    }
}

impl Words {
    /// The first `N` words of a texel.
    pub(crate) fn words<const N: usize>(&self, texel: Texel) -> [u32; N] {
        let first = (STRIDE * texel.0) as usize;
        std::array::from_fn(|index| {
            let bytes = self.0.get(first + 4 * index..first + 4 * index + 4);
            bytes.map_or(0, bytemuck::pod_read_unaligned)
        })
    }
}

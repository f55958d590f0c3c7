//! Photographs as shaders read them, one at a time.

use wgpu::util::DeviceExt as _;

use super::photograph::{Drawn, gpu_data::Photograph};
use crate::Gpu;

/// Bytes between photographs: no device wants more.
const STRIDE: usize = 256;
const _: () = assert!(size_of::<Photograph>() <= STRIDE, "photographs overlap");

/// The uniforms of photographs, on the device. A group each rather than dynamic offsets, with which
/// Mesa's software driver loses memory at every draw.
#[derive(Debug)]
pub(crate) struct PhotographUniforms {
    buffer: wgpu::Buffer,
}

impl PhotographUniforms {
    pub(crate) fn new(gpu: &Gpu, photographs: &[Drawn]) -> Self {
        // Buffers cannot be empty.
        let mut contents = vec![0; STRIDE * photographs.len().max(1)];
        for (slot, drawn) in contents.chunks_mut(STRIDE).zip(photographs) {
            let data = bytemuck::bytes_of(&drawn.data);
            slot[..data.len()].copy_from_slice(data);
        }
        let buffer = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("photographs"),
            contents: &contents,
            usage: wgpu::BufferUsages::UNIFORM,
        });
        Self { buffer }
    }

    /// The one at `index` of those given.
    pub(crate) fn of(&self, index: usize) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.buffer,
            offset: (index * STRIDE) as u64,
            size: std::num::NonZero::new(size_of::<Photograph>() as u64),
        })
    }
}

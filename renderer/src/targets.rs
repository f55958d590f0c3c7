//! The buffers and textures of one size of picture.

use glam::UVec2;

use crate::{Gpu, mesh, splat};

/// Everything that a view writes to, kept between frames of the same size.
#[derive(Debug)]
pub(crate) struct Targets {
    pub(crate) gbuffer_size: UVec2,
    pub(crate) picture_size: UVec2,
    pub(crate) planes: wgpu::TextureView,
    pub(crate) surfaces: wgpu::TextureView,
    pub(crate) depth: wgpu::TextureView,
    pub(crate) winners: wgpu::TextureView,
    pub(crate) point_depths: wgpu::Buffer,
    pub(crate) point_indices: wgpu::Buffer,
    pub(crate) picture: wgpu::Buffer,
    pub(crate) readback: wgpu::Buffer,
}

impl Targets {
    pub(crate) fn new(gpu: &Gpu, gbuffer_size: UVec2, picture_size: UVec2) -> Self {
        use wgpu::{BufferUsages, TextureUsages};
        let texture = |format, usage| {
            gpu.device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some("view"),
                    size: wgpu::Extent3d {
                        width: gbuffer_size.x,
                        height: gbuffer_size.y,
                        depth_or_array_layers: 1,
                    },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage,
                    view_formats: &[],
                })
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        let words = |size: UVec2, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("view"),
                size: u64::from(size.x) * u64::from(size.y) * 4,
                usage,
                mapped_at_creation: false,
            })
        };
        let drawn = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        Self {
            gbuffer_size,
            picture_size,
            planes: texture(mesh::PLANE_FORMAT, drawn),
            surfaces: texture(mesh::SURFACE_FORMAT, drawn),
            depth: texture(mesh::DEPTH_FORMAT, TextureUsages::RENDER_ATTACHMENT),
            winners: texture(
                splat::TARGET_FORMAT,
                TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
            ),
            point_depths: words(gbuffer_size, BufferUsages::STORAGE),
            point_indices: words(gbuffer_size, BufferUsages::STORAGE),
            picture: words(picture_size, BufferUsages::STORAGE | BufferUsages::COPY_SRC),
            readback: words(picture_size, BufferUsages::COPY_DST | BufferUsages::MAP_READ),
        }
    }
}

//! A picture on the device that can be drawn as another view would see it.

use flaneur_renderer::screen_pipeline;
use glam::{DMat3, UVec2};

/// Pictures as they come: bytes in, the same bytes out.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

mod gpu_data {
    /// `Screen` of reprojection.wgsl.
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    #[repr(C)]
    pub(super) struct Screen {
        pub(super) columns: [[f32; 4]; 3],
        pub(super) size: [f32; 2],
        pub(super) window: [f32; 2],
    }
}

/// How pictures are drawn.
#[derive(Debug)]
pub(super) struct Drawing {
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
}

/// A picture, drawn in one way.
#[derive(Debug)]
pub(super) struct Layer {
    pub(super) size: UVec2,
    texture: wgpu::Texture,
    uniforms: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

impl Drawing {
    /// By a fragment shader that follows reprojection.wgsl, onto targets of `format`.
    pub(super) fn new(
        device: &wgpu::Device,
        label: &str,
        wgsl: &str,
        format: wgpu::TextureFormat,
    ) -> Self {
        let wgsl = [include_str!("reprojection.wgsl"), wgsl].concat();
        let pipeline = screen_pipeline(device, label, &wgsl, &[format]);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some(label),
            address_mode_u: wgpu::AddressMode::MirrorRepeat,
            address_mode_v: wgpu::AddressMode::MirrorRepeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self { pipeline, sampler }
    }

    /// A picture of `size` pixels, without pixels so far.
    pub(super) fn layer(&self, device: &wgpu::Device, size: UVec2) -> Layer {
        let label = Some("picture");
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label,
            size: extent(size),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label,
            size: size_of::<gpu_data::Screen>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [
            uniforms.as_entire_binding(),
            wgpu::BindingResource::TextureView(&view),
            wgpu::BindingResource::Sampler(&self.sampler),
        ];
        let entries: Vec<_> = resources
            .into_iter()
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        Layer { size, texture, uniforms, bind_group }
    }

    /// Draws one whose frame sees a pixel of the target where `frame_from_screen` puts it; the sizes of
    /// frame and target, pixels.
    pub(super) fn draw(
        &self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::RenderPass<'_>,
        layer: &Layer,
        frame_from_screen: &DMat3,
        [size, window]: [UVec2; 2],
    ) {
        let column = |index: usize| frame_from_screen.col(index).as_vec3().extend(0.0).to_array();
        let uniforms = gpu_data::Screen {
            columns: [column(0), column(1), column(2)],
            size: size.as_vec2().to_array(),
            window: window.as_vec2().to_array(),
        };
        queue.write_buffer(&layer.uniforms, 0, bytemuck::bytes_of(&uniforms));
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &layer.bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl Layer {
    /// Fills it: sRGB with alpha, rows from the top.
    pub(super) fn fill(&self, queue: &wgpu::Queue, rgba: &[u8]) {
        queue.write_texture(
            self.texture.as_image_copy(),
            rgba,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * self.size.x),
                rows_per_image: Some(self.size.y),
            },
            extent(self.size),
        );
    }
}

fn extent(size: UVec2) -> wgpu::Extent3d {
    wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 }
}

//! The street behind everything else in the window: the last frame, turned to where one looks now.

use flaneur_renderer::screen_pipeline;
use flaneur_scene::View;
use glam::{DMat3, UVec2};

use super::reprojection::frame_from_screen;
use crate::commands::view::painter::Shown;

/// Frames as they come: bytes in, the same bytes out.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Draws it.
#[derive(Debug)]
pub(super) struct Picture {
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
    uniforms: wgpu::Buffer,
    frame: Option<Frame>,
}

/// What is shown.
#[derive(Debug)]
struct Frame {
    view: View,
    size: UVec2,
    texture: wgpu::Texture,
    bind_group: wgpu::BindGroup,
}

mod gpu_data {
    /// `Screen` of picture.wgsl.
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    #[repr(C)]
    pub(super) struct Screen {
        pub(super) columns: [[f32; 4]; 3],
        pub(super) size: [f32; 2],
        pub(super) padding: [f32; 2],
    }
}

impl Picture {
    /// Nothing yet, for targets of `format`.
    pub(super) fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let label = Some("picture");
        let wgsl = include_str!("picture.wgsl");
        let pipeline = screen_pipeline(device, "picture", wgsl, &[format]);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label,
            size: size_of::<gpu_data::Screen>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { pipeline, sampler, uniforms, frame: None }
    }

    /// Shows a new frame from now on.
    pub(super) fn show(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, shown: &Shown) {
        let size = shown.size;
        let frame = match self.frame.take().filter(|frame| frame.size == size) {
            Some(frame) => self.frame.insert(Frame { view: shown.view, ..frame }),
            None => {
                let frame = self.frame_of(device, size, shown.view);
                self.frame.insert(frame)
            }
        };
        queue.write_texture(
            frame.texture.as_image_copy(),
            &shown.rgba,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * size.x),
                rows_per_image: Some(size.y),
            },
            extent(size),
        );
    }

    /// Forgets it, as where it shows another scene.
    pub(super) fn clear(&mut self) {
        self.frame = None;
    }

    /// Draws it as `screen` would see it; nothing before the first frame.
    pub(super) fn draw(&self, queue: &wgpu::Queue, pass: &mut wgpu::RenderPass<'_>, screen: &View) {
        let Some(frame) = &self.frame else { return };
        let map: DMat3 = frame_from_screen(&frame.view, screen);
        let column = |index: usize| map.col(index).as_vec3().extend(0.0).to_array();
        let uniforms = gpu_data::Screen {
            columns: [column(0), column(1), column(2)],
            size: frame.size.as_vec2().to_array(),
            padding: [0.0; 2],
        };
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &frame.bind_group, &[]);
        pass.draw(0..3, 0..1);
    }

    fn frame_of(&self, device: &wgpu::Device, size: UVec2, view: View) -> Frame {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("frame"),
            size: extent(size),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let texture_view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [
            self.uniforms.as_entire_binding(),
            wgpu::BindingResource::TextureView(&texture_view),
            wgpu::BindingResource::Sampler(&self.sampler),
        ];
        let entries: Vec<_> = resources
            .into_iter()
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        Frame { view, size, texture, bind_group }
    }
}

fn extent(size: UVec2) -> wgpu::Extent3d {
    wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 }
}

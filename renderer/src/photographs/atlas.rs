//! Texture arrays that hold photographs of any size.
//!
//! There is no bindless access to textures everywhere, so photographs share a few arrays of
//! square layers, one array a size class. Each has its own
//! mip levels: corners are aligned so that no texel of any level holds two photographs, and
//! lookups stay half a texel inside.

use glam::UVec2;
use wgpu::util::DeviceExt as _;

use super::layout::{Layout, level_size};
pub(crate) use super::layout::{MAX_LOD, NoPlace, Place, SIDES};
use crate::{Gpu, memory};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// The shader that makes the levels.
pub(crate) const HALVE_WGSL: &str = include_str!("halve.wgsl");

pub(crate) mod gpu_data {
    /// Mirrors `Halve` in halve.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Halve {
        pub(crate) source_corner: [u32; 2],
        pub(crate) source_size: [u32; 2],
        pub(crate) target_corner: [u32; 2],
        pub(crate) padding: [u32; 2],
    }
}

#[derive(Debug)]
pub(crate) struct Atlas {
    layout: Layout,
    /// In the order of [`SIDES`].
    textures: [wgpu::Texture; SIDES.len()],
    halve: wgpu::RenderPipeline,
}

impl Atlas {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("halve"),
            source: wgpu::ShaderSource::Wgsl(HALVE_WGSL.into()),
        });
        let halve = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("halve"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vs"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fs"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let layout = Layout::new(&gpu.device.limits());
        Self { layout, textures: SIDES.map(|side| texture(gpu, side, 0)), halve }
    }

    /// Bytes of all arrays.
    pub(crate) fn bytes(&self) -> u64 {
        self.textures.iter().map(memory::of_texture).sum()
    }

    /// Views of all arrays, in the order of [`SIDES`].
    pub(crate) fn views(&self) -> Vec<wgpu::TextureView> {
        self.textures
            .iter()
            .map(|texture| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2Array),
                    ..Default::default()
                })
            })
            .collect()
    }

    /// Stores a picture (sRGB with alpha, `4 · size.x · size.y` bytes) and makes its levels.
    pub(crate) fn insert(
        &mut self,
        gpu: &Gpu,
        size: UVec2,
        rgba: &[u8],
        most: u64,
    ) -> Result<Place, NoPlace> {
        let place = self.take(gpu, size, most)?;
        gpu.queue.write_texture(
            self.part(&place, 0),
            rgba,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * size.x),
                rows_per_image: Some(size.y),
            },
            wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        );
        self.make_levels(gpu, &place);
        Ok(place)
    }

    /// Frees what [`Atlas::insert`] took.
    pub(crate) fn remove(&mut self, place: &Place) {
        self.layout.remove(place);
    }

    /// Where photographs lie.
    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Keeps of the photograph at `place` the level below its full one, and gives back the room of
    /// the rest. Where it lies then, see [`Layout::coarsen`]; `None`, and nothing kept, where there is
    /// no room to move it.
    pub(crate) fn coarsen(&mut self, gpu: &Gpu, place: &Place, most: u64) -> Option<Place> {
        let size = level_size(place.size, 1);
        let kept = texture_of_one(gpu, size);
        copy(gpu, self.part(place, 1), kept.as_image_copy(), size);
        let mut moved = self.layout.coarsen(place, most);
        if !self.resize(gpu) {
            moved = self.layout.take_beside(place, size);
        }
        let moved = moved?;
        copy(gpu, kept.as_image_copy(), self.part(&moved, 0), size);
        self.make_levels(gpu, &moved);
        Some(moved)
    }

    /// A level of a photograph.
    fn part(&self, place: &Place, level: u32) -> wgpu::TexelCopyTextureInfo<'_> {
        let corner = place.corner / (1 << level);
        wgpu::TexelCopyTextureInfo {
            texture: &self.textures[place.array],
            mip_level: level,
            origin: wgpu::Origin3d { x: corner.x, y: corner.y, z: place.layer },
            aspect: wgpu::TextureAspect::All,
        }
    }

    fn take(&mut self, gpu: &Gpu, size: UVec2, most: u64) -> Result<Place, NoPlace> {
        let taken = self.layout.take(size, most);
        if self.resize(gpu) {
            return taken;
        }
        let class = taken.map_or(0, |place| place.array);
        self.layout.take_between(class, size).ok_or(NoPlace::Device)
    }

    /// Gives the textures the layers of the layout; `false` where the device has no room for more, so
    /// that the layout has lost them again.
    fn resize(&mut self, gpu: &Gpu) -> bool {
        let wanted = self.layout.layers();
        let held = self.textures.each_ref().map(layers);
        // What is given back makes room for what is taken.
        for array in (0..SIDES.len()).filter(|&array| wanted[array] < held[array]) {
            // Where the device has no room for both, the larger one serves as well.
            self.resize_one(gpu, array, wanted[array]);
        }
        (0..SIDES.len()).filter(|&array| wanted[array] > held[array]).all(|array| {
            let resized = self.resize_one(gpu, array, wanted[array]);
            if !resized {
                self.layout.truncate(array, held[array]);
            }
            resized
        })
    }

    /// Whether the device had room for so many layers; what is there is kept either way.
    fn resize_one(&mut self, gpu: &Gpu, array: usize, wanted: usize) -> bool {
        let side = SIDES[array];
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let resized = texture(gpu, side, wanted);
        if pollster::block_on(scope.pop()).is_some() {
            return false;
        }
        let kept = layers(&self.textures[array]).min(wanted);
        if kept > 0 {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            for level in 0..=MAX_LOD {
                let part = |texture| wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: level,
                    origin: wgpu::Origin3d::ZERO,
                    aspect: wgpu::TextureAspect::All,
                };
                encoder.copy_texture_to_texture(
                    part(&self.textures[array]),
                    part(&resized),
                    wgpu::Extent3d {
                        width: side >> level,
                        height: side >> level,
                        depth_or_array_layers: kept as u32,
                    },
                );
            }
            gpu.queue.submit([encoder.finish()]);
        }
        self.textures[array] = resized;
        true
    }

    fn make_levels(&self, gpu: &Gpu, place: &Place) {
        let texture = &self.textures[place.array];
        let view = |level| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_mip_level: level,
                mip_level_count: Some(1),
                base_array_layer: place.layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for level in 1..=MAX_LOD {
            let corner = place.corner / (1 << level);
            let size = level_size(place.size, level);
            let uniform = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("halve"),
                contents: bytemuck::bytes_of(&gpu_data::Halve {
                    source_corner: (place.corner / (1 << (level - 1))).to_array(),
                    source_size: level_size(place.size, level - 1).to_array(),
                    target_corner: corner.to_array(),
                    padding: [0; 2],
                }),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let source = view(level - 1);
            let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("halve"),
                layout: &self.halve.get_bind_group_layout(0),
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                    wgpu::BindGroupEntry {
                        binding: 1,
                        resource: wgpu::BindingResource::TextureView(&source),
                    },
                ],
            });
            let target = view(level);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("halve"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            let (corner, extent) = (corner.as_vec2(), size.as_vec2());
            pass.set_viewport(corner.x, corner.y, extent.x, extent.y, 0.0, 1.0);
            pass.set_pipeline(&self.halve);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.draw(0..3, 0..1);
        }
        gpu.queue.submit([encoder.finish()]);
    }
}

/// Copies `size` texels.
fn copy(
    gpu: &Gpu,
    from: wgpu::TexelCopyTextureInfo<'_>,
    to: wgpu::TexelCopyTextureInfo<'_>,
    size: UVec2,
) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let extent = wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
    encoder.copy_texture_to_texture(from, to, extent);
    gpu.queue.submit([encoder.finish()]);
}

/// What a photograph waits in between two places.
fn texture_of_one(gpu: &Gpu, size: UVec2) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("photograph that moves"),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Layers of `side` pixels; without any a small one, because it is bound in any case.
fn texture(gpu: &Gpu, side: u32, layers: usize) -> wgpu::Texture {
    let side = if layers == 0 { 1 << MAX_LOD } else { side };
    let depth_or_array_layers = layers.max(1) as u32;
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("photographs"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers },
        mip_level_count: MAX_LOD + 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

/// How many layers for photographs a texture has.
fn layers(texture: &wgpu::Texture) -> usize {
    if texture.width() == 1 << MAX_LOD { 0 } else { texture.depth_or_array_layers() as usize }
}

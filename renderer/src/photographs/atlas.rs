//! Texture arrays that hold photographs of any size.
//!
//! There is no bindless access to textures everywhere, so photographs share a few arrays of
//! square layers, one array a size class. Each has its own
//! mip levels: corners are aligned so that no texel of any level holds two photographs, and
//! lookups stay half a texel inside.

use glam::UVec2;
use wgpu::util::DeviceExt as _;

use super::packing::Packing;
use crate::{Gpu, memory};

/// Sides of the layers of each array, pixels.
pub(crate) const SIDES: [u32; 4] = [1024, 2048, 4096, 8192];
/// Levels of detail below the full one.
pub(crate) const MAX_LOD: u32 = 4;
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

/// Where a photograph lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Index in [`SIDES`].
    pub(crate) array: usize,
    pub(crate) layer: u32,
    pub(crate) corner: UVec2,
    pub(crate) size: UVec2,
}

/// Why there is no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoPlace {
    /// The photograph is larger than the largest layer of the device.
    TooLarge { side: u32 },
    /// The textures would exceed what they may take.
    Memory,
    /// The device has no more layers or no more memory.
    Device,
}

#[derive(Debug)]
pub(crate) struct Atlas {
    arrays: Vec<Array>,
    halve: wgpu::RenderPipeline,
}

#[derive(Debug)]
struct Array {
    side: u32,
    texture: wgpu::Texture,
    layers: Vec<Packing>,
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
        let arrays = SIDES
            .map(|side| Array {
                side,
                // Bound in any case, so never without a layer; a small one while unused.
                texture: texture(gpu, 1 << MAX_LOD, 1),
                layers: Vec::new(),
            })
            .into();
        Self { arrays, halve }
    }

    /// Bytes of all layers, rounded up.
    fn held(&self) -> u64 {
        self.arrays.iter().map(|array| bytes(array.side, array.layers.len())).sum()
    }

    /// Bytes of all arrays.
    pub(crate) fn bytes(&self) -> u64 {
        self.arrays.iter().map(|array| memory::of_texture(&array.texture)).sum()
    }

    /// Views of all arrays, in the order of [`SIDES`].
    pub(crate) fn views(&self) -> Vec<wgpu::TextureView> {
        self.arrays
            .iter()
            .map(|array| {
                array.texture.create_view(&wgpu::TextureViewDescriptor {
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
        if let Some(packing) = self.arrays[place.array].layers.get_mut(place.layer as usize) {
            packing.give_back(place.corner);
        }
    }

    /// Whether a photograph of `size` has room once that at `place` is removed, without more layers.
    pub(crate) fn fits_without(&self, place: &Place, size: UVec2) -> bool {
        let array = &self.arrays[place.array];
        let Some(packing) = array.layers.get(place.layer as usize) else { return false };
        let mut packing = packing.clone();
        packing.give_back(place.corner);
        taken(size).max_element() <= array.side && packing.take(taken(size)).is_some()
    }

    /// Keeps of the photograph at `place` the level below its full one, and gives back the room of
    /// the rest. Where it lies then: it moves to where there is room for so little, so that what it
    /// leaves can serve one of its former size. `None` where the device has no room to move it.
    pub(crate) fn coarsen(&mut self, gpu: &Gpu, place: &Place, most: u64) -> Option<Place> {
        let size = level_size(place.size, 1);
        let kept = texture_of_one(gpu, size);
        copy(gpu, self.part(place, 1), kept.as_image_copy(), size);
        self.remove(place);
        let moved = self.take(gpu, size, most).ok().or_else(|| {
            let packing = self.arrays[place.array].layers.get_mut(place.layer as usize)?;
            Some(Place { corner: packing.take(taken(size))?, size, ..*place })
        })?;
        copy(gpu, kept.as_image_copy(), self.part(&moved, 0), size);
        self.make_levels(gpu, &moved);
        Some(moved)
    }

    /// A level of a photograph.
    fn part(&self, place: &Place, level: u32) -> wgpu::TexelCopyTextureInfo<'_> {
        let corner = place.corner / (1 << level);
        wgpu::TexelCopyTextureInfo {
            texture: &self.arrays[place.array].texture,
            mip_level: level,
            origin: wgpu::Origin3d { x: corner.x, y: corner.y, z: place.layer },
            aspect: wgpu::TextureAspect::All,
        }
    }

    fn take(&mut self, gpu: &Gpu, size: UVec2, most: u64) -> Result<Place, NoPlace> {
        let limits = gpu.device.limits();
        let side = limits.max_texture_dimension_2d.min(SIDES[SIDES.len() - 1]);
        let aligned = taken(size);
        let class = SIDES
            .iter()
            .position(|&class| class <= side && aligned.max_element() <= class)
            .ok_or(NoPlace::TooLarge { side })?;
        if let Some(place) = self.arrays[class].take(class, size) {
            return Ok(place);
        }
        let smallest = |atlas: &Self| atlas.held() + bytes(SIDES[class], 1);
        if smallest(self) > most {
            self.trim(gpu);
        }
        let held = self.held();
        let array = &mut self.arrays[class];
        // Half as much again, so that growing costs a bounded share of filling; a single
        // layer where there is no room for more.
        let layers = array.layers.len();
        let generous = layers + (layers / 2).max(1);
        let fits = |to: usize| held - bytes(array.side, layers) + bytes(array.side, to) <= most;
        let to = if fits(generous) { generous } else { layers + 1 };
        let may_grow = fits(to);
        let to = to.min(limits.max_texture_array_layers as usize);
        if may_grow && to > layers && array.grow(gpu, to) {
            return array.take(class, size).ok_or(NoPlace::Device);
        }
        // In between larger ones, then.
        let mut larger = class + 1..self.arrays.len();
        larger.find_map(|class| self.arrays[class].take(class, size)).ok_or(if may_grow {
            NoPlace::Device
        } else {
            NoPlace::Memory
        })
    }

    /// Gives layers at the end of arrays back to the device where no photograph lies in them.
    fn trim(&mut self, gpu: &Gpu) {
        for array in &mut self.arrays {
            let used = array.layers.iter().rposition(|layer| !layer.is_empty());
            let used = used.map_or(0, |last| last + 1);
            if used == 0 && !array.layers.is_empty() {
                array.texture = texture(gpu, 1 << MAX_LOD, 1);
                array.layers.clear();
            } else if used < array.layers.len() {
                array.layers.truncate(used);
                array.grow(gpu, used);
            }
        }
    }

    fn make_levels(&self, gpu: &Gpu, place: &Place) {
        let texture = &self.arrays[place.array].texture;
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

impl Array {
    fn take(&mut self, array: usize, size: UVec2) -> Option<Place> {
        self.layers.iter_mut().zip(0..).find_map(|(packing, layer)| {
            let corner = packing.take(taken(size))?;
            Some(Place { array, layer, corner, size })
        })
    }

    /// Whether the device had room for `layers` layers; what is there is kept either way.
    fn grow(&mut self, gpu: &Gpu, layers: usize) -> bool {
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let larger = texture(gpu, self.side, layers as u32);
        if pollster::block_on(scope.pop()).is_some() {
            return false;
        }
        if !self.layers.is_empty() {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            for level in 0..=MAX_LOD {
                let part = |texture| wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: level,
                    origin: wgpu::Origin3d::ZERO,
                    aspect: wgpu::TextureAspect::All,
                };
                encoder.copy_texture_to_texture(
                    part(&self.texture),
                    part(&larger),
                    wgpu::Extent3d {
                        width: self.side >> level,
                        height: self.side >> level,
                        depth_or_array_layers: self.layers.len() as u32,
                    },
                );
            }
            gpu.queue.submit([encoder.finish()]);
        }
        self.texture = larger;
        self.layers.resize_with(layers, || Packing::new(self.side));
        true
    }
}

/// The room that a photograph takes: corners of all levels stay whole texels.
fn taken(size: UVec2) -> UVec2 {
    size.map(|side| side.next_multiple_of(1 << MAX_LOD))
}

/// Size of a level, rounded up.
pub(super) fn level_size(size: UVec2, level: u32) -> UVec2 {
    size.map(|side| side.div_ceil(1 << level))
}

/// Bytes of `layers` layers with their levels, at most a third more than the full one.
fn bytes(side: u32, layers: usize) -> u64 {
    u64::from(side) * u64::from(side) * 4 * layers as u64 * 4 / 3
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

fn texture(gpu: &Gpu, side: u32, layers: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("photographs"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers },
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

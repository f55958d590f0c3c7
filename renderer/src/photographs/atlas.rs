//! Texture arrays that hold photographs of any size.
//!
//! There is no bindless access to textures everywhere, so photographs share a few arrays of layers,
//! one array a size class. Levels of detail lie below their photograph rather than in levels of the
//! texture, and texels are words rather than colours: shaders gather four of them at once and filter
//! themselves. That is exact on all devices, a half of the time on software ones, and the same four
//! texels tell whether a mask hides any of them.

use glam::UVec2;
use wgpu::util::DeviceExt as _;

use super::layout::{Layout, SIDES, level_size};
pub(crate) use super::layout::{MAX_LOD, NoPlace, Place};
use crate::layers::{all_layers, one_layer};
use crate::screen::{ScreenPass, WHOLE_WGSL, screen_pass};
use crate::{Gpu, SRGB_WGSL, memory};

/// Four bytes a texel, red in the lowest.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// The shader that makes the levels.
pub(crate) fn halve_wgsl() -> String {
    [WHOLE_WGSL, SRGB_WGSL, include_str!("halve.wgsl")].concat()
}

pub(crate) mod gpu_data {
    /// Mirrors `Halve` in halve.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Halve {
        pub(crate) source_corner: [u32; 2],
        pub(crate) source_size: [u32; 2],
    }
}

#[derive(Debug)]
pub(crate) struct Atlas {
    layout: Layout,
    /// In the order of [`SIDES`].
    textures: [wgpu::Texture; SIDES.len()],
    halve: ScreenPass,
}

impl Atlas {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let layout = Layout::new(&gpu.device.limits());
        let textures = SIDES.map(|_| texture(gpu, UVec2::ONE, 0));
        Self { layout, textures, halve: screen_pass(gpu, "halve", &halve_wgsl(), &[FORMAT]) }
    }

    /// Bytes of all arrays.
    pub(crate) fn bytes(&self) -> u64 {
        self.textures.iter().map(memory::of_texture).sum()
    }

    /// Views of all arrays, in the order of [`SIDES`].
    pub(crate) fn views(&self) -> Vec<wgpu::TextureView> {
        self.textures.iter().map(all_layers).collect()
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

    /// The array that holds what lies at `place`.
    pub(super) fn texture(&self, place: &Place) -> &wgpu::Texture {
        &self.textures[place.array]
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
        let corner = place.level_corner(level);
        wgpu::TexelCopyTextureInfo {
            texture: &self.textures[place.array],
            mip_level: 0,
            origin: wgpu::Origin3d { x: corner.x, y: corner.y, z: place.layer },
            aspect: wgpu::TextureAspect::All,
        }
    }

    fn take(&mut self, gpu: &Gpu, size: UVec2, most: u64) -> Result<Place, NoPlace> {
        loop {
            let taken = self.layout.take(size, most);
            // What the device refuses it is not asked for again.
            if self.resize(gpu) {
                return taken;
            }
        }
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
                self.layout.refused(array, wanted[array], held[array]);
            }
            resized
        })
    }

    /// Whether the device had room for so many layers; what is there is kept either way.
    fn resize_one(&mut self, gpu: &Gpu, array: usize, wanted: usize) -> bool {
        let size = self.layout.layer_size(array);
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let resized = texture(gpu, size, wanted);
        if pollster::block_on(scope.pop()).is_some() {
            return false;
        }
        let kept = layers(&self.textures[array]).min(wanted);
        if kept > 0 {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.copy_texture_to_texture(
                self.textures[array].as_image_copy(),
                resized.as_image_copy(),
                wgpu::Extent3d {
                    width: size.x,
                    height: size.y,
                    depth_or_array_layers: kept as u32,
                },
            );
            gpu.queue.submit([encoder.finish()]);
        }
        self.textures[array] = resized;
        true
    }

    fn make_levels(&self, gpu: &Gpu, place: &Place) {
        let layer = one_layer(&self.textures[place.array], place.layer);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        // A texture cannot be read and drawn into at once: each level is drawn apart and copied.
        let (mut source, mut source_corner) = (layer, place.corner);
        for level in 1..=place.coarsest() {
            let size = level_size(place.size, level);
            let uniform = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("halve"),
                contents: bytemuck::bytes_of(&gpu_data::Halve {
                    source_corner: source_corner.to_array(),
                    source_size: level_size(place.size, level - 1).to_array(),
                }),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let halved = texture_of_one(gpu, size);
            let target = halved.create_view(&Default::default());
            let bindings =
                vec![uniform.as_entire_binding(), wgpu::BindingResource::TextureView(&source)];
            self.halve.draw(gpu, &mut encoder, bindings, &[&target]);
            let extent = wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
            let part = self.part(place, level);
            encoder.copy_texture_to_texture(halved.as_image_copy(), part, extent);
            (source, source_corner) = (target, UVec2::ZERO);
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

/// What a level of a photograph is drawn into, or waits in between two places.
fn texture_of_one(gpu: &Gpu, size: UVec2) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("level of a photograph"),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// Layers of `size` pixels; without any a single pixel, because it is bound in any case.
fn texture(gpu: &Gpu, size: UVec2, layers: usize) -> wgpu::Texture {
    let UVec2 { x: width, y: height } = if layers == 0 { UVec2::ONE } else { size };
    let depth_or_array_layers = layers.max(1) as u32;
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("photographs"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// How many layers for photographs a texture has.
fn layers(texture: &wgpu::Texture) -> usize {
    if texture.width() == 1 { 0 } else { texture.depth_or_array_layers() as usize }
}

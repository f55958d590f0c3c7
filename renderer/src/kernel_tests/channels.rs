//! Runs passes over a picture, as they are, on small textures.

use glam::UVec2;
use wgpu::util::DeviceExt as _;

use super::{gpu, read};
use crate::depths::SHOWS_MESH;
use crate::layers::all_layers;
use crate::reference::field::Field;
use crate::screen::{ScreenPass, WHOLE_WGSL, screen_pass_with};
use crate::surface::{ORIENTATION_FORMAT, POSITION_FORMAT};

/// A texture of some channels of f32.
#[derive(Debug)]
pub(crate) struct Channels<const N: usize> {
    texture: wgpu::Texture,
    size: UVec2,
}

impl<const N: usize> Channels<N> {
    pub(crate) fn new(size: UVec2) -> Self {
        let texture = gpu().device.create_texture(&description::<N>(size));
        Self { texture, size }
    }

    pub(crate) fn holding(field: &Field<[f32; N]>) -> Self {
        let texture = gpu().device.create_texture_with_data(
            &gpu().queue,
            &description::<N>(field.size),
            wgpu::util::TextureDataOrder::LayerMajor,
            bytemuck::cast_slice(field.values.as_flattened()),
        );
        Self { texture, size: field.size }
    }

    pub(crate) fn view(&self) -> wgpu::TextureView {
        self.texture.create_view(&Default::default())
    }

    pub(crate) fn read(&self) -> Field<[f32; N]> {
        let texel = 4 * N as u32;
        let stride = (self.size.x * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let rows = gpu().device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(stride * self.size.y),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &rows,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride),
                    rows_per_image: None,
                },
            },
            self.texture.size(),
        );
        let floats: Vec<f32> = read(encoder, &rows);
        Field::new(self.size, |cell| {
            let first = (cell.y * stride + cell.x * texel) as usize / 4;
            std::array::from_fn(|i| floats[first + i])
        })
    }
}

/// The texels of a texture of floats, which no pass has to have copied from.
pub(crate) fn texels(view: &wgpu::TextureView) -> Field<[f32; 4]> {
    let size = view.texture().size();
    let found = Channels::<4>::new(UVec2::new(size.width, size.height));
    copy(view, &found.view());
    found.read()
}

/// Draws the texels of a texture of floats into another one of the same size.
pub(crate) fn copy(from: &wgpu::TextureView, to: &wgpu::TextureView) {
    const LOAD: &str = "
@group(0) @binding(0) var image: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return textureLoad(image, vec2<i32>(at.xy), 0);
}";
    let load = screen_pass_with(
        gpu(),
        "load",
        &[WHOLE_WGSL, LOAD].concat(),
        &[to.texture().format()],
        &[],
    );
    draw(&load, vec![wgpu::BindingResource::TextureView(from)], to);
}

/// Records of a picture as the surface pass leaves them: places relative to the eye that are mesh, and
/// where that is not so, directions.
pub(crate) fn records(size: UVec2, pixels: &[([f32; 3], bool)]) -> wgpu::TextureView {
    let word = |&([x, y, z], shows): &([f32; 3], bool)| {
        [x.to_bits(), y.to_bits(), z.to_bits(), if shows { SHOWS_MESH } else { 0 }]
    };
    record_words(&Field { size, values: pixels.iter().map(word).collect() })
}

/// The same from their words.
pub(crate) fn record_words(words: &Field<[u32; 4]>) -> wgpu::TextureView {
    let description =
        wgpu::TextureDescriptor { format: POSITION_FORMAT, ..description::<4>(words.size) };
    let texture = gpu().device.create_texture_with_data(
        &gpu().queue,
        &description,
        wgpu::util::TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(&words.values),
    );
    texture.create_view(&Default::default())
}

/// The codes of normals as the surface pass leaves them.
pub(crate) fn orientations(codes: &Field<u32>) -> wgpu::TextureView {
    orientation_words(&codes.each(|&code| [code, 0]))
}

/// The codes of normals, and those of points or classes of mesh.
pub(crate) fn orientation_words(words: &Field<[u32; 2]>) -> wgpu::TextureView {
    let description =
        wgpu::TextureDescriptor { format: ORIENTATION_FORMAT, ..description::<2>(words.size) };
    let texture = gpu().device.create_texture_with_data(
        &gpu().queue,
        &description,
        wgpu::util::TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(&words.values),
    );
    texture.create_view(&Default::default())
}

/// Fields of one size as the layers of a texture.
pub(crate) fn layers(fields: &[Field<[f32; 2]>]) -> wgpu::TextureView {
    let values: Vec<[f32; 2]> = fields.iter().flat_map(|field| field.values.clone()).collect();
    let mut description = description::<2>(fields[0].size);
    description.size.depth_or_array_layers = fields.len() as u32;
    let texture = gpu().device.create_texture_with_data(
        &gpu().queue,
        &description,
        wgpu::util::TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(&values),
    );
    all_layers(&texture)
}

/// The pass of that name among `sources`, with values for its override constants, into `N` channels
/// of f32.
pub(crate) fn pass<const N: usize>(
    sources: impl IntoIterator<Item = (&'static str, String)>,
    name: &str,
    constants: &[(&str, f64)],
) -> ScreenPass {
    let source = sources.into_iter().find(|(label, _)| *label == name);
    let (label, wgsl) = source.expect("a pass of this name");
    screen_pass_with(gpu(), label, &wgsl, &[format::<N>()], constants)
}

pub(crate) fn uniform<T: bytemuck::Pod>(value: &T) -> wgpu::Buffer {
    gpu().device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::bytes_of(value),
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

/// Draws one pass.
pub(crate) fn draw(
    pass: &ScreenPass,
    bindings: Vec<wgpu::BindingResource<'_>>,
    target: &wgpu::TextureView,
) {
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    pass.draw(gpu(), &mut encoder, bindings, &[target]);
    gpu().queue.submit([encoder.finish()]);
}

fn format<const N: usize>() -> wgpu::TextureFormat {
    match N {
        1 => wgpu::TextureFormat::R32Float,
        2 => wgpu::TextureFormat::Rg32Float,
        _ => wgpu::TextureFormat::Rgba32Float,
    }
}

fn description<const N: usize>(size: UVec2) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: format::<N>(),
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    }
}

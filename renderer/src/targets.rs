//! The buffers and textures of one size of picture.

use glam::UVec2;

use crate::splat::{self, Nearest, Route};
use crate::{Gpu, RenderError, memory, mesh, rest, screen, shade, surface};

/// Bytes of a pixel of all targets of the G-buffer's size, rounded up …
const GBUFFER_BYTES: u64 = 64;
/// … and of the picture's.
const PICTURE_BYTES: u64 = 72;

/// Everything that a view writes to, kept between frames of the same size. The first are of
/// the G-buffer's size, those from `records` on of the picture's.
#[derive(Debug)]
pub(crate) struct Targets {
    pub(crate) gbuffer_size: UVec2,
    pub(crate) picture_size: UVec2,
    pub(crate) planes: wgpu::TextureView,
    pub(crate) surfaces: wgpu::TextureView,
    pub(crate) depth: wgpu::TextureView,
    pub(crate) winners: wgpu::TextureView,
    pub(crate) winning_normals: wgpu::TextureView,
    pub(crate) nearest_points: Nearest,
    /// Where quads of points are drawn, see [`splat::quads`].
    pub(crate) canvas: wgpu::TextureView,
    /// What the pixels show.
    pub(crate) records: Records,
    /// Those of which nothing is known, see surface.wgsl.
    pub(crate) marks: wgpu::TextureView,
    pub(crate) choice: wgpu::TextureView,
    pub(crate) blended: wgpu::TextureView,
    /// The weight of what the nearest rigs have said, see rest/limit.wgsl.
    pub(crate) said: wgpu::TextureView,
    picture: wgpu::Texture,
    readback: wgpu::Buffer,
}

/// What the surface pass leaves of every pixel, see surface/place.wgsl.
#[derive(Debug)]
pub(crate) struct Records {
    pub(crate) positions: wgpu::TextureView,
    pub(crate) orientations: wgpu::TextureView,
}

impl Targets {
    pub(crate) fn new(gpu: &Gpu, gbuffer_size: UVec2, picture_size: UVec2, route: Route) -> Self {
        use wgpu::{BufferUsages, TextureUsages};
        let texture = |format, size: UVec2, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("view"),
                size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let view =
            |format, size, usage| texture(format, size, usage).create_view(&Default::default());
        let drawn = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let target = TextureUsages::RENDER_ATTACHMENT;
        let read = drawn | TextureUsages::COPY_SRC;
        Self {
            gbuffer_size,
            picture_size,
            planes: view(mesh::PLANE_FORMAT, gbuffer_size, drawn),
            surfaces: view(mesh::SURFACE_FORMAT, gbuffer_size, drawn),
            depth: view(mesh::DEPTH_FORMAT, gbuffer_size, target),
            winners: view(splat::WINNERS_FORMAT, gbuffer_size, drawn),
            winning_normals: view(splat::WINNING_NORMALS_FORMAT, gbuffer_size, drawn),
            nearest_points: Nearest::new(gpu, gbuffer_size, route),
            canvas: splat::quads::canvas(gpu, gbuffer_size),
            records: Records {
                positions: view(surface::POSITION_FORMAT, picture_size, read),
                orientations: view(surface::ORIENTATION_FORMAT, picture_size, read),
            },
            marks: view(screen::MARKS_FORMAT, picture_size, target),
            choice: view(shade::CHOICE_FORMAT, picture_size, target),
            blended: view(shade::blend_format(gpu), picture_size, drawn),
            said: view(rest::SAID_FORMAT, picture_size, drawn),
            picture: texture(shade::PICTURE_FORMAT, picture_size, target | TextureUsages::COPY_SRC),
            readback: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture"),
                size: u64::from(row_bytes(picture_size)) * u64::from(picture_size.y),
                usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
                mapped_at_creation: false,
            }),
        }
    }

    /// Bytes that [`Targets::bytes`] is at most for a G-buffer and a picture of these sizes.
    pub(crate) fn bytes_for(gbuffer_size: UVec2, picture_size: UVec2) -> u64 {
        let pixels = |size: UVec2| u64::from(size.x) * u64::from(size.y);
        // Rows of the picture are padded where it is copied out.
        let padding = u64::from(picture_size.y) * u64::from(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        GBUFFER_BYTES * pixels(gbuffer_size) + PICTURE_BYTES * pixels(picture_size) + padding + 512
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        let Self { planes, surfaces, depth, winners, winning_normals, .. } = self;
        let Self { canvas, records, marks, choice, blended, said, .. } = self;
        let Records { positions, orientations } = records;
        let shown = [positions, orientations, marks];
        let views = [planes, surfaces, depth, winners, winning_normals, canvas].into_iter();
        let views = views.chain([choice, blended, said]);
        let views = views.chain(shown).map(|view| memory::of_texture(view.texture()));
        views.sum::<u64>()
            + memory::of_texture(&self.picture)
            + self.nearest_points.bytes()
            + self.readback.size()
    }

    pub(crate) fn picture_view(&self) -> wgpu::TextureView {
        self.picture.create_view(&Default::default())
    }

    /// Copies the picture to where [`Targets::read_picture`] finds it.
    pub(crate) fn copy_picture(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_texture_to_buffer(
            self.picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.readback,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row_bytes(self.picture_size)),
                    rows_per_image: None,
                },
            },
            self.picture.size(),
        );
    }

    /// Waits for the device and gives the picture, four bytes a pixel, rows from the top.
    pub(crate) fn read_picture(&self, gpu: &Gpu) -> Result<Vec<u8>, RenderError> {
        let row = 4 * self.picture_size.x as usize;
        let mut picture = Vec::with_capacity(row * self.picture_size.y as usize);
        read_with(gpu, &self.readback, |padded| {
            for padded in padded.chunks_exact(row_bytes(self.picture_size) as usize) {
                picture.extend_from_slice(&padded[..row]);
            }
        })?;
        Ok(picture)
    }
}

/// Bytes between rows of a picture that is copied out: devices want multiples of 256.
fn row_bytes(size: UVec2) -> u32 {
    (4 * size.x).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Waits for the device and copies the buffer out.
pub(crate) fn read_back(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, RenderError> {
    let mut bytes = Vec::new();
    read_with(gpu, buffer, |mapped| bytes.extend_from_slice(mapped))?;
    Ok(bytes)
}

/// Waits for the device and lets what the buffer holds be read.
fn read_with(
    gpu: &Gpu,
    buffer: &wgpu::Buffer,
    read: impl FnOnce(&[u8]),
) -> Result<(), RenderError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver outlives the wait below.
        let _ = sender.send(result);
    });
    gpu.device
        .poll(wgpu::PollType::wait_indefinitely())
        .map_err(|error| RenderError::Driver(error.to_string()))?;
    // Where several renderers share the device, another's wait may be the one that answers,
    // a moment after this one's ended.
    match receiver.recv() {
        Ok(Ok(())) => {
            let mapped = buffer
                .get_mapped_range(..)
                .map_err(|error| RenderError::Driver(error.to_string()))?;
            read(&mapped);
            drop(mapped);
            buffer.unmap();
            Ok(())
        }
        Ok(Err(error)) => Err(RenderError::Driver(error.to_string())),
        Err(error) => Err(RenderError::Driver(error.to_string())),
    }
}

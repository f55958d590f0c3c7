//! How far away the pixels of a frame are, for those who measure.

use glam::DVec3;

use crate::targets::read_back;
use crate::{Gpu, RenderError};

/// Bytes of a record of the positions, see surface/place.wgsl.
const RECORD_BYTES: u32 = 16;
/// The bits of a record's flags that tell what a pixel shows, and what they are for mesh and
/// points; `KIND_BITS` and `SHOWS_*` in surface/place.wgsl.
pub(crate) const KIND_BITS: u32 = 7;
pub(crate) const SHOWS_MESH: u32 = 1;
pub(crate) const SHOWS_POINT: u32 = 3;

/// Depth along `forward` (unit, world) of each record of `positions`, metres; `None` where it
/// shows neither mesh nor points.
pub(crate) fn read(
    gpu: &Gpu,
    positions: &wgpu::TextureView,
    forward: DVec3,
) -> Result<Vec<Option<f32>>, RenderError> {
    let texture = positions.texture();
    let size = texture.size();
    let row_bytes =
        (RECORD_BYTES * size.width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("positions"),
        size: u64::from(row_bytes) * u64::from(size.height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row_bytes),
                rows_per_image: None,
            },
        },
        size,
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = read_back(gpu, &buffer)?;
    let rows = bytes.chunks_exact(row_bytes as usize);
    let records =
        rows.flat_map(|row| row.chunks_exact(RECORD_BYTES as usize).take(size.width as usize));
    let forward = forward.as_vec3();
    Ok(records
        .map(|record| {
            let [x, y, z, flags] = bytemuck::pod_read_unaligned::<[u32; 4]>(record);
            let position = glam::Vec3::from_array([x, y, z].map(f32::from_bits));
            matches!(flags & KIND_BITS, SHOWS_MESH | SHOWS_POINT).then(|| forward.dot(position))
        })
        .collect())
}

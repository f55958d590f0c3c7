//! Runs pieces of shaders on the device, for comparison with their references.

use wgpu::util::DeviceExt as _;

use crate::Gpu;

pub(crate) mod channels;

/// The device that all tests of this crate share.
pub(crate) fn gpu() -> &'static Gpu {
    static GPU: std::sync::OnceLock<Gpu> = std::sync::OnceLock::new();
    GPU.get_or_init(|| Gpu::new().expect("a graphics driver"))
}

/// Any number from 0 to 1, the same for the same cell and seed.
pub(crate) fn noise(cell: glam::UVec2, seed: u32) -> f32 {
    let mut bits = cell.x.wrapping_mul(0x9e37_79b1) ^ cell.y.wrapping_mul(0x85eb_ca77);
    bits = (bits ^ seed.wrapping_mul(0xc2b2_ae3d)).wrapping_mul(0x27d4_eb2f);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297a_2d39);
    ((bits ^ (bits >> 15)) >> 8) as f32 / (1 << 24) as f32
}

/// Runs `main` of `source` for `count` invocations of a workgroup of 64, with `inputs` at
/// bindings 0… and room for `outputs` values at the next; gives those.
pub(crate) fn run<T: bytemuck::Pod>(
    source: &str,
    inputs: &[&[u8]],
    count: usize,
    outputs: usize,
) -> Vec<T> {
    let gpu = gpu();
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("kernel"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("kernel"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let mut buffers: Vec<wgpu::Buffer> = inputs
        .iter()
        .map(|contents| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents,
                usage: wgpu::BufferUsages::STORAGE,
            })
        })
        .collect();
    buffers.push(gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: (outputs * size_of::<T>()) as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    }));
    let entries: Vec<_> = buffers
        .iter()
        .zip(0..)
        .map(|(buffer, binding)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(count.div_ceil(64) as u32, 1, 1);
    }
    read(encoder, &buffers[inputs.len()])
}

/// Submits `encoder` and gives what `buffer` then holds.
pub(crate) fn read<T: bytemuck::Pod>(
    mut encoder: wgpu::CommandEncoder,
    buffer: &wgpu::Buffer,
) -> Vec<T> {
    let gpu = gpu();
    let readback = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    encoder.copy_buffer_to_buffer(buffer, 0, &readback, 0, None);
    gpu.queue.submit([encoder.finish()]);
    readback.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("device works");
    let bytes = readback.get_mapped_range(..).expect("mapped").to_vec();
    bytemuck::pod_collect_to_vec(&bytes)
}

/// Where the pixels of a picture are, relative to the eye, from the surface pass's records.
pub(crate) fn positions(
    records: &wgpu::TextureView,
    size: glam::UVec2,
) -> Vec<Option<glam::DVec3>> {
    let places = places(records, size);
    places.into_iter().map(|(place, shows)| shows.then_some(place)).collect()
}

/// The same, and in which direction, unit, those look that show nothing; which of both they are.
pub(crate) fn places(records: &wgpu::TextureView, size: glam::UVec2) -> Vec<(glam::DVec3, bool)> {
    const KERNEL: &str = "
@group(0) @binding(0) var records: texture_2d<u32>;
@group(0) @binding(1) var<storage, read_write> copied: array<vec4<u32>>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(records);
    if all(id.xy < size) {
        copied[id.y * size.x + id.x] = textureLoad(records, id.xy, 0);
    }
}";
    let gpu = gpu();
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("positions"),
        source: wgpu::ShaderSource::Wgsl(KERNEL.into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("positions"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let copied = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(size.element_product()) * 16,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(records),
            },
            wgpu::BindGroupEntry { binding: 1, resource: copied.as_entire_binding() },
        ],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(size.x.div_ceil(8), size.y.div_ceil(8), 1);
    }
    let records: Vec<[u32; 4]> = read(encoder, &copied);
    records
        .into_iter()
        .map(|[x, y, z, flags]| {
            let position = [x, y, z].map(|bits| f64::from(f32::from_bits(bits)));
            (position.into(), flags != 0)
        })
        .collect()
}

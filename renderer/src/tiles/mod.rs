//! Which photographs can see something of which part of a picture.
//!
//! The picture is cut into tiles. The places that a tile shows lie in a box; a photograph whose
//! pyramid misses the box is not drawn over the tile. The device makes the lists and draws
//! from them, so that nothing waits for the host.

use glam::{DVec3, UVec2};
use wgpu::util::DeviceExt as _;

use crate::Gpu;
use crate::frustum::Frustum;

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;

/// Pixels a side of a tile; `TILE` in tiles.wgsl and photograph.wgsl.
pub(crate) const TILE: u32 = 32;

pub(crate) const WGSL: &str = include_str!("tiles.wgsl");

pub(crate) mod gpu_data {
    /// Mirrors `Frame` in tiles.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Frame {
        pub(crate) size: [u32; 2],
        pub(crate) columns: u32,
        pub(crate) tile_count: u32,
        pub(crate) photograph_count: u32,
        pub(crate) apart: u32,
        pub(crate) padding: [u32; 2],
    }

    /// Mirrors `Pyramid` in tiles.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Pyramid {
        pub(crate) planes: [[f32; 4]; 5],
        pub(crate) rig: u32,
        pub(crate) padding_0: u32,
        pub(crate) padding_1: u32,
        pub(crate) padding_2: u32,
    }

    /// Mirrors `Draw` in tiles.wgsl, and what an indirect draw reads.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Draw {
        pub(crate) vertex_count: u32,
        pub(crate) instance_count: u32,
        pub(crate) first_vertex: u32,
        pub(crate) first_instance: u32,
    }
}

/// How far beside a photograph's pyramid its tiles may lie, metres: positions are rounded.
const MARGIN_M: f64 = 1e-3;

/// What the pixels of a picture show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<'a> {
    /// World.
    pub(crate) eye: DVec3,
    /// Of the picture, pixels.
    pub(crate) size: UVec2,
    /// Relative to the eye, see surface/place.wgsl.
    pub(crate) positions: &'a wgpu::TextureView,
}

/// The vertex buffer of lists.
pub(crate) const TILE_ATTRIBUTE: wgpu::VertexBufferLayout<'_> = wgpu::VertexBufferLayout {
    array_stride: 4,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![0 => Uint32],
};

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct TilePass {
    layout: wgpu::BindGroupLayout,
    bound: wgpu::ComputePipeline,
    list: wgpu::ComputePipeline,
}

/// The tiles of every photograph of a frame, on the device.
#[derive(Debug)]
pub(crate) struct TileLists {
    lists: wgpu::Buffer,
    draws: wgpu::Buffer,
    tile_count: u32,
}

impl TileLists {
    /// Draws a strip of four corners over each tile of the photograph `index`, of those that it
    /// has to itself or of those that it shares with others of its rig; the tile, column
    /// in the low half and row in the high, is the attribute of vertex buffer 0.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, index: u32, alone: bool) {
        let draw = 2 * u64::from(index) + u64::from(alone);
        let bytes = u64::from(self.tile_count) * 4;
        pass.set_vertex_buffer(0, self.lists.slice(draw * bytes..(draw + 1) * bytes));
        pass.draw_indirect(&self.draws, draw * size_of::<gpu_data::Draw>() as u64);
    }
}

impl TilePass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("tiles"),
            source: wgpu::ShaderSource::Wgsl(WGSL.into()),
        });
        let layout = layout(gpu);
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("tiles"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |entry_point| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self { bound: pipeline("bound"), list: pipeline("list"), layout }
    }

    /// Lists the tiles of the photographs, each by what it can see and by its rig; `None` where
    /// there is no photograph. Those that a photograph has to itself are listed apart where that
    /// is wanted.
    pub(crate) fn lists(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        photographs: &[(&Frustum, usize)],
        apart: bool,
        shown: Shown<'_>,
    ) -> Option<TileLists> {
        let Shown { eye, size, positions } = shown;
        let tiles = size.map(|side| side.div_ceil(TILE));
        let tile_count = tiles.element_product();
        let pyramids: Vec<_> =
            photographs.iter().map(|(frustum, rig)| pyramid(frustum, *rig, eye)).collect();
        if pyramids.is_empty() {
            return None;
        }
        let nothing = gpu_data::Draw {
            vertex_count: 4,
            instance_count: 0,
            first_vertex: 0,
            first_instance: 0,
        };
        let filled = |contents: &[u8], usage| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("tiles"),
                contents,
                usage,
            })
        };
        let empty = |size, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("tiles"),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let frame = gpu_data::Frame {
            size: size.to_array(),
            columns: tiles.x,
            tile_count,
            photograph_count: pyramids.len() as u32,
            apart: u32::from(apart),
            padding: [0; 2],
        };
        let frame = filled(bytemuck::bytes_of(&frame), Usage::UNIFORM);
        let boxes = empty(u64::from(tile_count) * 32, Usage::STORAGE);
        let pyramids_on_device = filled(bytemuck::cast_slice(&pyramids), Usage::STORAGE);
        let draws = vec![nothing; 2 * pyramids.len()];
        let draws = filled(
            bytemuck::cast_slice(&draws),
            Usage::STORAGE | Usage::INDIRECT | Usage::COPY_SRC,
        );
        let bytes = u64::from(tile_count) * 8 * pyramids.len() as u64;
        let lists = empty(bytes, Usage::STORAGE | Usage::VERTEX | Usage::COPY_SRC);
        let resources = [
            frame.as_entire_binding(),
            wgpu::BindingResource::TextureView(positions),
            boxes.as_entire_binding(),
            pyramids_on_device.as_entire_binding(),
            draws.as_entire_binding(),
            lists.as_entire_binding(),
        ];
        let entries: Vec<_> = resources
            .into_iter()
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("tiles"),
            layout: &self.layout,
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(0, &bind_group, &[]);
        pass.set_pipeline(&self.bound);
        let UVec2 { x, y } = tiles;
        pass.dispatch_workgroups(x, y, 1);
        pass.set_pipeline(&self.list);
        pass.dispatch_workgroups(tile_count.div_ceil(64), 1, 1);
        drop(pass);
        Some(TileLists { lists, draws, tile_count })
    }
}

/// The four sides of what a photograph sees, and its eye plane, relative to `eye`.
fn pyramid(frustum: &Frustum, rig: usize, eye: DVec3) -> gpu_data::Pyramid {
    let planes = frustum
        .planes()
        .map(|(n, place)| n.extend(MARGIN_M - n.dot(place - eye)).as_vec4().to_array());
    gpu_data::Pyramid { planes, rig: rig as u32, ..bytemuck::Zeroable::zeroed() }
}

fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("tiles"),
        entries: &[
            entry(0, buffer(wgpu::BufferBindingType::Uniform)),
            entry(
                1,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
            entry(2, storage(false)),
            entry(3, storage(true)),
            entry(4, storage(false)),
            entry(5, storage(false)),
        ],
    })
}

//! Which photographs can see something of which part of a picture.
//!
//! The picture is cut into tiles. The places that a tile shows lie in a box; a photograph whose
//! pyramid misses the box is not drawn over the tile. The device makes the lists and draws
//! from them, so that nothing waits for the host.
//!
//! Equations and reasons are in reference.rs.

use flaneur_scene::{View, ViewProjection};
use glam::{DVec3, DVec4, UVec2};
use wgpu::util::DeviceExt as _;

use crate::Gpu;
use crate::bindings::bind_group_at;
use crate::frustum::Frustum;

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;

/// Pixels a side of a tile; `TILE` in shaders.
pub(crate) const TILE: u32 = 32;
/// Tiles a side of a block; `BLOCK` in tiles.wgsl.
pub(crate) const BLOCK: u32 = 4;

pub(crate) const WGSL: &str = include_str!("tiles.wgsl");

pub(crate) mod gpu_data {
    /// Mirrors `Frame` in tiles.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Frame {
        pub(crate) size: [u32; 2],
        pub(crate) columns: u32,
        pub(crate) rows: u32,
        pub(crate) right: [f32; 3],
        pub(crate) apart: u32,
        pub(crate) down: [f32; 3],
        pub(crate) orthographic: u32,
        pub(crate) forward: [f32; 3],
        pub(crate) padding: u32,
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
/// And by which tangent: so are directions.
const MARGIN: f64 = 1e-5;

/// What the pixels of a picture show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<'a> {
    /// Whose picture it is.
    pub(crate) view: &'a View,
    /// Of the picture, pixels: another than the view's where several are made for it, one below the other.
    pub(crate) size: UVec2,
    /// Relative to the eye, see surface/place.wgsl.
    pub(crate) positions: &'a wgpu::TextureView,
}

/// The boxes of a picture, and what lists photographs by them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tiled<'a> {
    pub(crate) pass: &'a TilePass,
    pub(crate) boxes: &'a TileBoxes,
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
    bound: wgpu::ComputePipeline,
    meet: wgpu::ComputePipeline,
    list: wgpu::ComputePipeline,
}

/// What the tiles of a picture show, on the device.
#[derive(Debug)]
pub(crate) struct TileBoxes {
    /// Of each tile the box around its places.
    boxes: wgpu::Buffer,
    /// And which rigs are asked about it, a bit each: all, unless [`crate::rest`] says otherwise.
    pub(crate) asked: wgpu::Buffer,
    view: View,
    /// Of the picture, pixels.
    size: UVec2,
}

impl TileBoxes {
    /// The same, of which no rig is asked about any tile yet.
    pub(crate) fn asking_nobody(&self, gpu: &Gpu) -> Self {
        let asked = asked_of(gpu, self.size, 0);
        Self { boxes: self.boxes.clone(), asked, view: self.view, size: self.size }
    }
}

/// The tiles of some photographs of a frame, on the device.
#[derive(Debug)]
pub(crate) struct TileLists {
    lists: wgpu::Buffer,
    draws: wgpu::Buffer,
    tile_count: u32,
}

impl TileLists {
    /// Draws a strip of four corners over each square of tiles of the photograph `index` of those listed, of those
    /// that it has to itself or of those that it shares with others of its rig; the square, as
    /// tiles.wgsl has it, is the attribute of vertex buffer 0.
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
        let pipeline = |entry_point| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self { bound: pipeline("bound"), meet: pipeline("meet"), list: pipeline("list") }
    }

    /// The boxes around what the tiles of a picture show.
    pub(crate) fn boxes(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        shown: Shown<'_>,
    ) -> TileBoxes {
        let Shown { view, size, positions } = shown;
        let tiles = tiles_of(size);
        let boxes = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("tiles"),
            size: u64::from(tiles.element_product()) * 32,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let asked = asked_of(gpu, size, u32::MAX);
        let frame = frame(gpu, view, size, false);
        let resources = vec![
            (0, frame.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(positions)),
            (2, boxes.as_entire_binding()),
        ];
        dispatch(gpu, encoder, &self.bound, resources, tiles);
        TileBoxes { boxes, asked, view: *view, size }
    }

    /// Lists the tiles of the photographs, each by what it can see and by its rig, of which the nearest
    /// come first; `None` where there is no photograph. Those that a photograph has to itself are
    /// listed apart where that is wanted.
    pub(crate) fn lists(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        photographs: &[(&Frustum, usize)],
        apart: bool,
        shown: &TileBoxes,
    ) -> Option<TileLists> {
        let &TileBoxes { ref boxes, ref asked, ref view, size } = shown;
        let tile_count = tiles_of(size).element_product();
        let pyramids: Vec<_> =
            photographs.iter().map(|(frustum, rig)| pyramid(frustum, *rig, view)).collect();
        if pyramids.is_empty() {
            return None;
        }
        let nothing = gpu_data::Draw {
            vertex_count: 4,
            instance_count: 0,
            first_vertex: 0,
            first_instance: 0,
        };
        use wgpu::BufferUsages as Usage;
        let frame = frame(gpu, view, size, apart);
        let pyramids_on_device = filled(gpu, bytemuck::cast_slice(&pyramids), Usage::STORAGE);
        let draws = vec![nothing; 2 * pyramids.len()];
        let draws = filled(
            gpu,
            bytemuck::cast_slice(&draws),
            Usage::STORAGE | Usage::INDIRECT | Usage::COPY_SRC,
        );
        let lists = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("tiles"),
            size: u64::from(tile_count) * 8 * pyramids.len() as u64,
            usage: Usage::STORAGE | Usage::VERTEX | Usage::COPY_SRC,
            mapped_at_creation: false,
        });
        let blocks = tiles_of(size).map(|tiles| tiles.div_ceil(BLOCK)).element_product();
        let met = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("tiles"),
            size: u64::from(blocks) * 4 * pyramids.len() as u64,
            usage: Usage::STORAGE,
            mapped_at_creation: false,
        });
        let workgroups = UVec2::new(blocks.div_ceil(32), pyramids.len() as u32);
        let both = [
            (0, frame.as_entire_binding()),
            (3, pyramids_on_device.as_entire_binding()),
            (7, met.as_entire_binding()),
        ];
        let mut resources = both.to_vec();
        resources.extend([(2, boxes.as_entire_binding()), (6, asked.as_entire_binding())]);
        dispatch(gpu, encoder, &self.meet, resources, workgroups);
        let mut resources = both.to_vec();
        resources.extend([(4, draws.as_entire_binding()), (5, lists.as_entire_binding())]);
        dispatch(gpu, encoder, &self.list, resources, workgroups);
        Some(TileLists { lists, draws, tile_count })
    }
}

/// How many tiles a picture has in both directions.
pub(crate) fn tiles_of(picture: UVec2) -> UVec2 {
    picture.map(|side| side.div_ceil(TILE))
}

fn frame(gpu: &Gpu, view: &View, size: UVec2, apart: bool) -> wgpu::Buffer {
    let tiles = tiles_of(size);
    let axes = view.camera.cam_from_world.transpose();
    let frame = gpu_data::Frame {
        size: size.to_array(),
        columns: tiles.x,
        rows: tiles.y,
        right: axes.x_axis.as_vec3().to_array(),
        apart: u32::from(apart),
        down: axes.y_axis.as_vec3().to_array(),
        orthographic: u32::from(view.projection == ViewProjection::Orthographic),
        forward: axes.z_axis.as_vec3().to_array(),
        padding: 0,
    };
    filled(gpu, bytemuck::bytes_of(&frame), wgpu::BufferUsages::UNIFORM)
}

/// Who is asked about each tile of a picture: the same everywhere.
fn asked_of(gpu: &Gpu, size: UVec2, rigs: u32) -> wgpu::Buffer {
    let tiles = vec![rigs; tiles_of(size).element_product() as usize];
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    filled(gpu, bytemuck::cast_slice(&tiles), usage)
}

fn filled(gpu: &Gpu, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("tiles"),
        contents,
        usage,
    })
}

fn dispatch(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    resources: Vec<(u32, wgpu::BindingResource<'_>)>,
    workgroups: UVec2,
) {
    let group = bind_group_at(gpu, "tiles", &pipeline.get_bind_group_layout(0), resources);
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(workgroups.x, workgroups.y, 1);
}

/// The four sides of what a photograph sees, and its eye plane, in the coordinates of a view's boxes.
fn pyramid(frustum: &Frustum, rig: usize, view: &View) -> gpu_data::Pyramid {
    let planes = frustum.planes().map(|(n, on)| in_view(n, on, view).as_vec4().to_array());
    gpu_data::Pyramid { planes, rig: rig as u32, ..bytemuck::Zeroable::zeroed() }
}

/// The plane with the normal `n` through `on`, moved outwards by the margins.
fn in_view(n: DVec3, on: DVec3, view: &View) -> DVec4 {
    let inward = view.camera.cam_from_world * n;
    let beyond = MARGIN_M - n.dot(on - view.eye());
    match view.projection {
        ViewProjection::Perspective => DVec4::new(inward.x, inward.y, beyond, inward.z + MARGIN),
        ViewProjection::Orthographic => inward.extend(beyond),
    }
}

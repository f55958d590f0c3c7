//! Meshes: what is resident, and how it is rasterised.
//!
//! The G-buffer keeps, per pixel, the plane of the triangle rather than a depth: the ray of
//! any pixel position then gives the exact point, also where a distorted view looks the
//! G-buffer up between its pixel centres.

use std::collections::BTreeMap;

use flaneur_scene::{Bounds3, MeshTile, TileKey};
use glam::{DVec3, Vec3};
use wgpu::util::DeviceExt as _;

use crate::bindings::bind_group;
use crate::camera::gpu_data::Camera;
use crate::frustum::Frustum;
use crate::{Gpu, RenderError, camera};

mod evict;
pub(crate) mod reference;
#[cfg(test)]
mod tests;

pub(crate) const PLANE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub(crate) const SURFACE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Depths of a depth map.
pub(crate) const MAP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// The shader of both passes.
pub(crate) fn wgsl() -> String {
    [camera::WGSL, include_str!("mesh.wgsl")].concat()
}

pub(crate) mod gpu_data {
    /// The vertex attributes of `Vertex` in mesh.wgsl, locations 0 to 3.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Vertex {
        pub(crate) position: [f32; 3],
        pub(crate) normal: [f32; 3],
        pub(crate) uncertainty: f32,
        pub(crate) class: u32,
    }
}

/// Resident tiles.
#[derive(Debug, Default)]
pub(crate) struct MeshStore {
    tiles: BTreeMap<TileKey, Tile>,
    /// Triangles that were left out.
    pub(crate) refused: u64,
}

#[derive(Debug)]
struct Tile {
    origin: DVec3,
    bounds: Bounds3,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl Tile {
    /// Bytes on the device.
    fn bytes(&self) -> u64 {
        self.vertices.size() + self.indices.size()
    }
}

impl MeshStore {
    /// Adds or replaces a tile; gives the box that changed, empty where nothing did.
    /// Triangles with a corner that is not finite are left out.
    ///
    /// Where all would take more than `most` bytes, the tiles farthest from `eye` are given up, with
    /// their boxes in `evicted`; where those that are farther than the tile are not enough, they stay
    /// and the tile itself is given up, with what it was to replace.
    pub(crate) fn insert(
        &mut self,
        gpu: &Gpu,
        tile: &MeshTile,
        most: u64,
        eye: DVec3,
        evicted: &mut Vec<(TileKey, Bounds3)>,
    ) -> Result<Bounds3, RenderError> {
        check(gpu, tile)?;
        let (vertices, indices) = (vertices(tile), indices(tile));
        self.refused += (tile.indices.len() - indices.len()) as u64 / 3;
        let mut bounds = Bounds3::EMPTY;
        for &index in &indices {
            let p = Vec3::from_array(vertices[index as usize].position).as_dvec3();
            bounds.include(tile.origin + p);
        }
        let replaced = self.tiles.get(&tile.key).map_or(0, Tile::bytes);
        let needed = (size_of_val(&vertices[..]) + size_of_val(&indices[..])) as u64;
        let needed = if indices.is_empty() { 0 } else { needed };
        let lacking = (self.bytes() - replaced + needed).saturating_sub(most);
        let farther = self.farther(tile.key, &bounds, eye, lacking);
        let mut changed = self.remove(tile.key);
        let Some(farther) = farther else {
            evicted.push((tile.key, changed));
            return Ok(changed);
        };
        for key in farther {
            evicted.push((key, self.remove(key)));
        }
        if !indices.is_empty() {
            changed = changed.union(&bounds);
            let buffer = |contents: &[u8], usage| {
                gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some("mesh tile"),
                    contents,
                    usage,
                })
            };
            let tile_on_device = Tile {
                origin: tile.origin,
                bounds,
                vertices: buffer(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
                indices: buffer(bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
                index_count: indices.len() as u32,
            };
            self.tiles.insert(tile.key, tile_on_device);
        }
        Ok(changed)
    }

    /// Removes a tile; gives the box that changed, empty where there was none.
    pub(crate) fn remove(&mut self, key: TileKey) -> Bounds3 {
        self.tiles.remove(&key).map_or(Bounds3::EMPTY, |tile| tile.bounds)
    }

    /// What is resident.
    pub(crate) fn bounds(&self) -> Bounds3 {
        self.tiles.values().fold(Bounds3::EMPTY, |all, tile| all.union(&tile.bounds))
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.tiles.values().map(Tile::bytes).sum()
    }

    pub(crate) fn triangle_count(&self) -> u64 {
        self.tiles.values().map(|tile| u64::from(tile.index_count) / 3).sum()
    }

    /// What `frustum` may see, placed relative to `centre`; the nearest first, so that they hide
    /// others before those are drawn.
    pub(crate) fn draw_list(&self, gpu: &Gpu, frustum: &Frustum, centre: DVec3) -> DrawList<'_> {
        let mut tiles: Vec<&Tile> =
            self.tiles.values().filter(|tile| frustum.meets_box(&tile.bounds, 0.0)).collect();
        tiles.sort_by(|a, b| a.bounds.distance(centre).total_cmp(&b.bounds.distance(centre)));
        let origins: Vec<[f32; 3]> =
            tiles.iter().map(|tile| (tile.origin - centre).as_vec3().to_array()).collect();
        let origins = (!origins.is_empty()).then(|| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("mesh tile origins"),
                contents: bytemuck::cast_slice(&origins),
                usage: wgpu::BufferUsages::VERTEX,
            })
        });
        DrawList { tiles, origins }
    }
}

/// Tiles to be drawn for one camera.
#[derive(Debug)]
pub(crate) struct DrawList<'a> {
    tiles: Vec<&'a Tile>,
    origins: Option<wgpu::Buffer>,
}

impl DrawList<'_> {
    /// Draws nothing after all.
    pub(crate) fn clear(&mut self) {
        self.tiles.clear();
    }

    pub(crate) fn triangle_count(&self) -> u64 {
        self.tiles.iter().map(|tile| u64::from(tile.index_count) / 3).sum()
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Some(origins) = &self.origins else { return };
        pass.set_vertex_buffer(1, origins.slice(..));
        for (tile, instance) in self.tiles.iter().zip(0..) {
            pass.set_vertex_buffer(0, tile.vertices.slice(..));
            pass.set_index_buffer(tile.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..tile.index_count, 0, instance..instance + 1);
        }
    }
}

/// The ways a mesh is rasterised.
#[derive(Debug)]
pub(crate) struct MeshPass {
    gbuffer: wgpu::RenderPipeline,
    depth: wgpu::RenderPipeline,
    /// `None` where the device draws no lines.
    edges: Option<wgpu::RenderPipeline>,
}

/// What draws a view's mesh: its surfaces, and in the same pass maybe their edges.
#[derive(Clone, Copy, Debug)]
struct Pipelines<'a> {
    surfaces: &'a wgpu::RenderPipeline,
    edges: Option<&'a wgpu::RenderPipeline>,
}

impl MeshPass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("mesh"),
            source: wgpu::ShaderSource::Wgsl(wgsl().into()),
        });
        let pipeline = |vertex, entry, targets: &[Option<wgpu::ColorTargetState>], polygon_mode| {
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entry),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[
                        Some(wgpu::VertexBufferLayout {
                            array_stride: size_of::<gpu_data::Vertex>() as u64,
                            step_mode: wgpu::VertexStepMode::Vertex,
                            attributes: &wgpu::vertex_attr_array![
                                0 => Float32x3, 1 => Float32x3, 2 => Float32, 3 => Uint32
                            ],
                        }),
                        Some(wgpu::VertexBufferLayout {
                            array_stride: 12,
                            step_mode: wgpu::VertexStepMode::Instance,
                            attributes: &wgpu::vertex_attr_array![4 => Float32x3],
                        }),
                    ],
                },
                primitive: wgpu::PrimitiveState { polygon_mode, ..Default::default() },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH_FORMAT,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets,
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let written = |format: wgpu::TextureFormat| Some(wgpu::ColorTargetState::from(format));
        let unwritten = |format| {
            let write_mask = wgpu::ColorWrites::empty();
            Some(wgpu::ColorTargetState { format, blend: None, write_mask })
        };
        let view = [written(PLANE_FORMAT), written(SURFACE_FORMAT)];
        let lines = [unwritten(PLANE_FORMAT), written(SURFACE_FORMAT)];
        let (fill, line) = (wgpu::PolygonMode::Fill, wgpu::PolygonMode::Line);
        let draws_lines = gpu.device.features().contains(wgpu::Features::POLYGON_MODE_LINE);
        Self {
            gbuffer: pipeline("vs", "fs_gbuffer", &view, fill),
            depth: pipeline("vs", "fs_depth", &[written(MAP_FORMAT), written(MAP_FORMAT)], fill),
            edges: draws_lines.then(|| pipeline("vs_edges", "fs_edges", &lines, line)),
        }
    }

    /// Fills the planes and surfaces of a view; pixels without mesh have surface 0. With
    /// `edges`, surfaces are marked along the edges of triangles.
    #[expect(clippy::too_many_arguments, reason = "one argument a target")]
    pub(crate) fn draw_gbuffer(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        list: &DrawList<'_>,
        edges: bool,
        planes: &wgpu::TextureView,
        surfaces: &wgpu::TextureView,
        depth: &wgpu::TextureView,
    ) {
        let clear = wgpu::Color::TRANSPARENT;
        let attachments = [attachment(planes, clear), attachment(surfaces, clear)];
        let edges = self.edges.as_ref().filter(|_| edges);
        let pipelines = Pipelines { surfaces: &self.gbuffer, edges };
        draw(gpu, encoder, pipelines, camera, list, &attachments, depth);
    }

    /// Fills the part of a depth map that `camera` covers; texels without mesh get a depth
    /// beyond everything. The map's layers are of depth and of that by its uncertainty behind it.
    pub(crate) fn draw_depth(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        list: &DrawList<'_>,
        [map, behind]: &[wgpu::TextureView; 2],
        depth: &wgpu::TextureView,
    ) {
        let clear = wgpu::Color { r: reference::NO_MESH_M, ..wgpu::Color::TRANSPARENT };
        let attachments = [attachment(map, clear), attachment(behind, clear)];
        let pipelines = Pipelines { surfaces: &self.depth, edges: None };
        draw(gpu, encoder, pipelines, camera, list, &attachments, depth);
    }
}

fn draw(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    pipelines: Pipelines<'_>,
    camera: &Camera,
    list: &DrawList<'_>,
    color_attachments: &[Option<wgpu::RenderPassColorAttachment<'_>>],
    depth: &wgpu::TextureView,
) {
    let uniform = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("mesh camera"),
        contents: bytemuck::bytes_of(camera),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("mesh"),
        color_attachments,
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    let [width, height] = camera.size;
    pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
    for pipeline in [Some(pipelines.surfaces), pipelines.edges].into_iter().flatten() {
        let layout = pipeline.get_bind_group_layout(0);
        let group = bind_group(gpu, "mesh", &layout, [uniform.as_entire_binding()]);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        list.draw(&mut pass);
    }
}

fn attachment(
    view: &wgpu::TextureView,
    clear: wgpu::Color,
) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
    })
}

fn check(gpu: &Gpu, tile: &MeshTile) -> Result<(), RenderError> {
    let vertices = tile.vertices.len();
    let bad = |index| RenderError::MeshIndex { key: tile.key, index, vertices };
    let index_count = u32::try_from(tile.indices.len()).unwrap_or(u32::MAX);
    if index_count == u32::MAX || !index_count.is_multiple_of(3) {
        return Err(bad(index_count));
    }
    if let Some(&index) = tile.indices.iter().find(|&&index| index as usize >= vertices) {
        return Err(bad(index));
    }
    let limit = gpu.device.limits().max_buffer_size;
    let bytes = (vertices * size_of::<gpu_data::Vertex>()).max(tile.indices.len() * 4) as u64;
    if bytes > limit {
        return Err(RenderError::MeshSize { key: tile.key, bytes, limit });
    }
    Ok(())
}

fn vertices(tile: &MeshTile) -> Vec<gpu_data::Vertex> {
    tile.vertices
        .iter()
        .map(|vertex| gpu_data::Vertex {
            position: vertex.position,
            normal: Vec3::from_array(vertex.normal).normalize_or(Vec3::Z).to_array(),
            uncertainty: usable(vertex.uncertainty_m),
            class: vertex.class as u32,
        })
        .collect()
}

/// An uncertainty in metres; what is none, or no number, is 0.
pub(crate) fn usable(uncertainty_m: f32) -> f32 {
    if uncertainty_m > 0.0 && uncertainty_m.is_finite() { uncertainty_m } else { 0.0 }
}

/// The indices of the triangles that can be drawn.
fn indices(tile: &MeshTile) -> Vec<u32> {
    if !tile.origin.is_finite() {
        return Vec::new();
    }
    let finite =
        |&index: &u32| tile.vertices[index as usize].position.iter().all(|x| x.is_finite());
    tile.indices
        .chunks_exact(3)
        .filter(|triangle| triangle.iter().all(finite))
        .flatten()
        .copied()
        .collect()
}

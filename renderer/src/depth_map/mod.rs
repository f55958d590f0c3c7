//! The photographs' depth maps: drawn from the mesh, refined as points arrive.
//!
//! Maps are made when a view first needs their photograph. Changes are noted at once, for
//! the maps that they can touch, and drawn when the map is next needed: new points are added
//! to what is there; lost points, or another mesh, redraw that layer of the map.

use std::collections::{BTreeSet, HashMap, HashSet};

use flaneur_scene::{Bounds3, ImageId, PointNodeId};

use crate::camera::gpu_data::Camera;
use crate::layers::{all_layers, one_layer};
use crate::mesh::{self, MeshPass, MeshStore};
use crate::photographs::{Photograph, PhotographStore};
use crate::points::{PointStore, Precedence};
use crate::splat::{self, SplatPass};
use crate::{Gpu, Settings, memory};

pub(crate) mod reference;
#[cfg(test)]
mod tests;

/// The depth test, to be put before the shader that uses it.
pub(crate) const WGSL: &str = include_str!("depth_map.wgsl");
/// What a map of points holds, to be put before the shaders that read one.
pub(crate) const POINT_WGSL: &str = include_str!("point.wgsl");

/// Most photographs with a depth map.
pub(crate) const MAX_MAPS: usize = 128;
/// Most bytes of a texture: software devices have no larger ones.
const MOST_OF_TEXTURE: u64 = (1 << 31) - 1;
const POINTS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
const FIRST_MAPS: usize = 8;

/// Depth maps of the photographs in use.
#[derive(Debug)]
pub(crate) struct DepthMaps {
    side: u32,
    /// Whether points are drawn into them.
    refined: bool,
    precedence: Precedence,
    max_maps: usize,
    slots: HashMap<ImageId, Slot>,
    textures: Textures,
    frame: u64,
}

/// Where a map lies in the textures of all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MapPlace {
    pub(crate) layer: u32,
    /// Of a layer, texels.
    pub(crate) side: u32,
}

#[derive(Debug)]
struct Slot {
    layer: usize,
    last_used: u64,
    /// The frame that drew it last.
    drawn: u64,
    mesh_is_stale: bool,
    points_are_stale: bool,
    /// Chunks that have arrived since the points were drawn.
    pending: BTreeSet<PointNodeId>,
}

/// Two layers a map of mesh depth and of that by the mesh's uncertainty behind it, since a place is compared
/// with one or the other; and one of point depth. Software devices gather textures of one channel far
/// more quickly than others.
#[derive(Debug)]
struct Textures {
    layers: usize,
    mesh: wgpu::Texture,
    points: wgpu::Texture,
    /// The layer of point depth that is being drawn: there are atomics in buffers only.
    scratch: wgpu::Buffer,
    depth: wgpu::TextureView,
}

/// What drawing maps needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sources<'a> {
    pub(crate) mesh_pass: &'a MeshPass,
    pub(crate) splat_pass: &'a SplatPass,
    pub(crate) mesh: &'a MeshStore,
    pub(crate) points: &'a PointStore,
}

impl DepthMaps {
    /// Maps of at most their share of the memory together, but at least one.
    pub(crate) fn new(gpu: &Gpu, settings: &Settings) -> Self {
        let (side, refined) = (settings.depth_map_side, settings.refine_by_points);
        let precedence = if settings.near_first { Precedence::Map } else { Precedence::None };
        let limits = gpu.device.limits();
        let max_maps = MAX_MAPS
            .min(limits.max_texture_array_layers as usize / 2)
            .min((MOST_OF_TEXTURE / (2 * layer_bytes(side))) as usize)
            .min(Self::most_maps(side, settings.shares().depth_maps).max(1));
        let textures = Textures::new(gpu, side, FIRST_MAPS.min(max_maps));
        Self { side, refined, precedence, max_maps, slots: HashMap::new(), textures, frame: 0 }
    }

    /// How many maps fit into so many bytes: two words a texel for the mesh and one for points,
    /// beside one of each for drawing.
    pub(crate) fn most_maps(side: u32, bytes: u64) -> usize {
        let maps = (bytes / layer_bytes(side)).saturating_sub(2) / 3;
        usize::try_from(maps).unwrap_or(MAX_MAPS)
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        let Textures { mesh, points, scratch, depth, .. } = &self.textures;
        let textures = [mesh, points, depth.texture()].map(memory::of_texture);
        textures.iter().sum::<u64>() + scratch.size()
    }

    /// How many photographs one frame may use.
    pub(crate) fn max_maps(&self) -> usize {
        self.max_maps
    }

    /// Where a photograph's map lies, if it has one.
    pub(crate) fn place(&self, id: &ImageId) -> Option<MapPlace> {
        self.slots.get(id).map(|slot| MapPlace { layer: slot.layer as u32, side: self.side })
    }

    /// Another number whenever a photograph's map changes; `None` where it has none.
    pub(crate) fn revision(&self, id: &ImageId) -> Option<u64> {
        self.slots.get(id).map(|slot| slot.drawn)
    }

    /// What is read of maps by those who ask for a place: mesh depth with what is still the mesh, and point
    /// depth, in the layers of [`DepthMaps::mesh_view`] and [`DepthMaps::points_view`].
    pub(crate) fn textures(&self) -> [&wgpu::Texture; 2] {
        [&self.textures.mesh, &self.textures.points]
    }

    /// All layers of mesh depth, each before that of points that are still the mesh.
    pub(crate) fn mesh_view(&self) -> wgpu::TextureView {
        all_layers(&self.textures.mesh)
    }

    /// All layers of point depth.
    pub(crate) fn points_view(&self) -> wgpu::TextureView {
        all_layers(&self.textures.points)
    }

    pub(crate) fn forget(&mut self, id: &ImageId) {
        self.slots.remove(id);
    }

    /// Notes that the mesh changed within `bounds`.
    pub(crate) fn mesh_changed(&mut self, photographs: &PhotographStore, bounds: &Bounds3) {
        for slot in self.touched(photographs, bounds, 0.0) {
            slot.mesh_is_stale = true;
        }
    }

    /// Notes that points arrived within `bounds`.
    pub(crate) fn points_added(
        &mut self,
        photographs: &PhotographStore,
        id: PointNodeId,
        bounds: &Bounds3,
        margin_m: f64,
    ) {
        for slot in self.touched(photographs, bounds, margin_m) {
            slot.pending.insert(id);
        }
    }

    /// Notes that points were lost within `bounds`.
    pub(crate) fn points_removed(
        &mut self,
        photographs: &PhotographStore,
        bounds: &Bounds3,
        margin_m: f64,
    ) {
        for slot in self.touched(photographs, bounds, margin_m) {
            slot.points_are_stale = true;
        }
    }

    /// Gives each selected photograph a map and brings it up to date.
    pub(crate) fn prepare(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        sources: &Sources<'_>,
        selected: &[(&ImageId, &Photograph)],
    ) {
        self.frame += 1;
        self.reserve(gpu, selected.len());
        for (id, _) in selected {
            if let Some(slot) = self.slots.get_mut(*id) {
                slot.last_used = self.frame;
            }
        }
        for (id, photograph) in selected {
            self.assign(id);
            let Some(slot) = self.slots.get_mut(*id) else { continue };
            let camera = Camera::new(&photograph.camera, &photograph.map);
            if std::mem::take(&mut slot.mesh_is_stale) {
                slot.drawn = self.frame;
                let centre = photograph.camera.centre;
                let list = sources.mesh.draw_list(gpu, &photograph.frustum, centre);
                let (map, depth) = (self.textures.mesh_layers(slot.layer), &self.textures.depth);
                sources.mesh_pass.draw_depth(gpu, encoder, &camera, &list, &map, depth);
            }
            let pending = std::mem::take(&mut slot.pending);
            let redraw = std::mem::take(&mut slot.points_are_stale);
            if redraw || !pending.is_empty() {
                slot.drawn = self.frame;
                let (frustum, centre) = (&photograph.frustum, photograph.camera.centre);
                let max_radius_m = splat::MAX_MAP_RADIUS_M;
                let wanted = |id: &PointNodeId| self.refined && (redraw || pending.contains(id));
                let list =
                    sources.points.map_list(frustum, centre, max_radius_m, self.precedence, wanted);
                if redraw && list.blocks.is_empty() {
                    self.textures.empty(encoder, slot.layer);
                    continue;
                }
                let scratch = &self.textures.scratch;
                let (whole, buffer) = self.textures.points_layer(slot.layer, self.side);
                if redraw {
                    sources.splat_pass.clear(gpu, encoder, scratch.as_entire_buffer_binding());
                } else {
                    encoder.copy_texture_to_buffer(whole, buffer, self.textures.layer_size());
                }
                let (pass, store) = (sources.splat_pass, sources.points);
                let depths = scratch.as_entire_buffer_binding();
                pass.draw_depth(gpu, encoder, store, &list, &camera, &depths, self.side);
                encoder.copy_buffer_to_texture(buffer, whole, self.textures.layer_size());
            }
        }
    }

    fn touched<'a>(
        &'a mut self,
        photographs: &'a PhotographStore,
        bounds: &'a Bounds3,
        margin_m: f64,
    ) -> impl Iterator<Item = &'a mut Slot> {
        let touched: HashSet<&ImageId> = photographs
            .iter()
            .filter(|(_, photograph)| {
                !bounds.is_empty() && photograph.frustum.meets_box(bounds, margin_m)
            })
            .map(|(id, _)| id)
            .collect();
        self.slots.iter_mut().filter(move |(id, _)| touched.contains(id)).map(|(_, slot)| slot)
    }

    /// Makes room for `wanted` maps. Maps that exist are drawn again in larger textures:
    /// that happens a few times in a renderer's life.
    pub(crate) fn reserve(&mut self, gpu: &Gpu, wanted: usize) {
        if wanted > self.textures.layers && self.textures.layers < self.max_maps {
            let layers = wanted.next_power_of_two().min(self.max_maps);
            self.textures = Textures::new(gpu, self.side, layers);
            self.slots.clear();
        }
    }

    /// Gives a photograph without a map a free layer, or that of the map whose last use is
    /// longest ago.
    fn assign(&mut self, id: &ImageId) {
        if self.slots.contains_key(id) {
            return;
        }
        let used: HashSet<usize> = self.slots.values().map(|slot| slot.layer).collect();
        let free = (0..self.textures.layers).find(|layer| !used.contains(layer));
        let oldest = || {
            let (id, slot) = self
                .slots
                .iter()
                .filter(|(_, slot)| slot.last_used < self.frame)
                .min_by_key(|(_, slot)| slot.last_used)?;
            Some((id.clone(), slot.layer))
        };
        let layer = match free {
            Some(layer) => layer,
            None => match oldest() {
                Some((oldest, layer)) => {
                    self.slots.remove(&oldest);
                    layer
                }
                None => return,
            },
        };
        self.slots.insert(
            id.clone(),
            Slot {
                layer,
                last_used: self.frame,
                drawn: self.frame,
                mesh_is_stale: true,
                points_are_stale: true,
                pending: BTreeSet::new(),
            },
        );
    }
}

impl Textures {
    fn new(gpu: &Gpu, side: u32, layers: usize) -> Self {
        let texture = |format, layers, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("depth maps"),
                size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let empty = wgpu::TextureUsages::empty();
        let bound = wgpu::TextureUsages::TEXTURE_BINDING;
        let copied = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
        Self {
            layers,
            mesh: texture(
                mesh::MAP_FORMAT,
                2 * layers as u32,
                bound | wgpu::TextureUsages::COPY_SRC,
            ),
            points: texture(POINTS_FORMAT, layers as u32, bound | copied),
            scratch: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("depth map of points"),
                size: layer_bytes(side),
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            depth: texture(mesh::DEPTH_FORMAT, 1, empty).create_view(&Default::default()),
        }
    }

    /// Where mesh depth is drawn, and what is still the mesh.
    fn mesh_layers(&self, layer: usize) -> [wgpu::TextureView; 2] {
        [0, 1].map(|which| one_layer(&self.mesh, 2 * layer as u32 + which))
    }

    /// Leaves a layer without points: much quicker than to copy it from a scratch buffer without.
    fn empty(&self, encoder: &mut wgpu::CommandEncoder, layer: usize) {
        let view = one_layer(&self.points, layer as u32);
        let nothing = wgpu::Color { r: f64::NAN, ..wgpu::Color::TRANSPARENT };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("no points"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(nothing),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
    }

    /// A layer of point depth, and the scratch buffer that is copied from or to it.
    fn points_layer(
        &self,
        layer: usize,
        side: u32,
    ) -> (wgpu::TexelCopyTextureInfo<'_>, wgpu::TexelCopyBufferInfo<'_>) {
        let texture = wgpu::TexelCopyTextureInfo {
            texture: &self.points,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: 0, z: layer as u32 },
            aspect: wgpu::TextureAspect::All,
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * side),
            rows_per_image: None,
        };
        (texture, wgpu::TexelCopyBufferInfo { buffer: &self.scratch, layout })
    }

    fn layer_size(&self) -> wgpu::Extent3d {
        wgpu::Extent3d { depth_or_array_layers: 1, ..self.points.size() }
    }
}

fn layer_bytes(side: u32) -> u64 {
    u64::from(side) * u64::from(side) * 4
}

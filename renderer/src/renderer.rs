//! What is resident, and the order of the passes that make a frame of it.

use flaneur_scene::{Bounds3, SceneUpdate, View};
use glam::UVec2;

use crate::camera::gpu_data::Camera;
use crate::depth_map::{DepthMaps, Sources};
use crate::frame::{Frame, FrameStats};
use crate::frustum::Frustum;
use crate::mesh::{MeshPass, MeshStore};
use crate::photographs::{PhotographStore, camera_fault};
use crate::pinhole::Pinhole;
use crate::points::PointStore;
use crate::shade::{self, GBuffer, ShadePass, tiles};
use crate::splat::{SplatPass, ViewTarget};
use crate::targets::Targets;
use crate::{Gpu, RenderError, Settings, lens};

/// Most pixels of a picture, and of the G-buffer behind it: a word each fits a storage
/// binding of 128 MiB.
const MAX_PIXELS: u64 = 1 << 25;

/// Holds a scene on the device and renders views of it.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    settings: Settings,
    mesh_pass: MeshPass,
    splat_pass: SplatPass,
    shade_pass: ShadePass,
    mesh: MeshStore,
    points: PointStore,
    photographs: PhotographStore,
    maps: DepthMaps,
    targets: Option<Targets>,
}

impl Renderer {
    /// An empty scene, with default settings.
    pub fn new(gpu: &Gpu) -> Self {
        Self::with_settings(gpu, Settings::default())
    }

    /// An empty scene. Settings outside their range are brought into it.
    pub fn with_settings(gpu: &Gpu, settings: Settings) -> Self {
        // Rows of whole storage alignments.
        let depth_map_side = settings.depth_map_side.clamp(16, 2048).next_multiple_of(8);
        let settings = Settings { depth_map_side, ..settings };
        Self {
            gpu: gpu.clone(),
            settings,
            mesh_pass: MeshPass::new(gpu),
            splat_pass: SplatPass::new(gpu),
            shade_pass: ShadePass::new(gpu),
            mesh: MeshStore::default(),
            points: PointStore::default(),
            photographs: PhotographStore::new(gpu),
            maps: DepthMaps::new(gpu, depth_map_side),
            targets: None,
        }
    }

    /// Changes what is resident. Dropping what is not there is no error.
    ///
    /// Triangles and points that are not finite are left out; the points are counted in
    /// [`FrameStats::points_refused`].
    ///
    /// # Errors
    /// Where the update contradicts itself or exceeds a budget; what is resident then stays
    /// as it was.
    pub fn apply(&mut self, update: SceneUpdate) -> Result<(), RenderError> {
        match update {
            SceneUpdate::Mesh(tile) => {
                let changed = self.mesh.insert(&self.gpu, &tile)?;
                self.maps.mesh_changed(&self.photographs, &changed);
            }
            SceneUpdate::DropMesh(key) => {
                let changed = self.mesh.remove(key);
                self.maps.mesh_changed(&self.photographs, &changed);
            }
            SceneUpdate::Points(chunk) => {
                let change = self.points.insert(&self.gpu, &self.settings, &chunk)?;
                self.points_removed(&change.removed);
                let margin_m = f64::from(self.settings.max_splat_radius_m);
                let id = chunk.id;
                self.maps.points_added(&self.photographs, id, &change.added, margin_m);
            }
            SceneUpdate::DropPoints(id) => {
                let removed = self.points.remove(id);
                self.points_removed(&removed);
            }
            SceneUpdate::Image(image) => {
                if self.photographs.insert(&self.gpu, &self.settings, &image)? {
                    self.maps.forget(&image.id);
                }
            }
            SceneUpdate::DropImage(id) => {
                self.photographs.remove(&id);
                self.maps.forget(&id);
            }
        }
        Ok(())
    }

    /// The picture that the view's camera would take of what is resident.
    ///
    /// # Errors
    /// Where the view's camera or size cannot be used, or the driver fails.
    pub fn render(&mut self, view: &View) -> Result<Frame, RenderError> {
        let pinhole = self.check(view)?;
        let size = view.size();
        let eye = view.eye();
        let camera = Camera::new(&view.camera, &pinhole);
        let frustum = Frustum::new(&view.camera, &pinhole);
        let (gpu, settings) = (&self.gpu, &self.settings);
        self.points.upload(gpu);
        if !self.targets.as_ref().is_some_and(|targets| {
            targets.gbuffer_size == pinhole.size && targets.picture_size == size
        }) {
            self.targets = None;
        }
        let targets = self.targets.get_or_insert_with(|| Targets::new(gpu, pinhole.size, size));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());

        let selected = self.photographs.select(&frustum, eye, settings.rigs, self.maps.max_maps());
        let sources = Sources {
            mesh_pass: &self.mesh_pass,
            splat_pass: &self.splat_pass,
            mesh: &self.mesh,
            points: &self.points,
        };
        self.maps.prepare(gpu, &mut encoder, &sources, &selected);

        let drawn_mesh = self.mesh.draw_list(gpu, &frustum, eye);
        let (planes, surfaces) = (&targets.planes, &targets.surfaces);
        let pass = &self.mesh_pass;
        pass.draw_gbuffer(
            gpu,
            &mut encoder,
            &camera,
            &drawn_mesh,
            planes,
            surfaces,
            &targets.depth,
        );

        let points = self.points.view_list(&frustum, eye);
        let target = ViewTarget {
            depths: &targets.point_depths,
            indices: &targets.point_indices,
            winners: &targets.winners,
        };
        self.splat_pass.draw_view(gpu, &mut encoder, &self.points, &points, &camera, target);

        let mut photographs: Vec<shade::gpu_data::Photograph> = Vec::new();
        let mut seen = Vec::new();
        let mut rig = (0, "");
        for (id, photograph) in &selected {
            if rig.1 != id.panorama() {
                rig = (rig.0 + 1, id.panorama());
            }
            if let Some(layer) = self.maps.layer(id) {
                photographs.push(shade::gpu_data::Photograph::new(photograph, eye, rig.0, layer));
                seen.push(*photograph);
            }
        }
        let picture_lens = lens::gpu_data::Lens::new(&view.camera.lens);
        let distorted = picture_lens.model != 0;
        let grid = if distorted { lens::undistortion_grid(&view.camera.lens) } else { Vec::new() };
        let tiles = tiles::lists(view, &grid, &seen);
        let frame = shade::gpu_data::Frame {
            camera,
            lens: picture_lens,
            background: settings.background.map(|c| f32::from(c) / 255.0),
            photograph_count: photographs.len() as u32,
            grid_columns: lens::grid_size(size).x,
            grid_step: lens::GRID_STEP as f32,
            map_side: self.maps.side(),
            tile_columns: tiles::columns(size),
        };
        let gbuffer = GBuffer {
            planes,
            surfaces,
            winners: &targets.winners,
            indices: &targets.point_indices,
        };
        let (maps, atlas) = (&self.maps, &self.photographs.atlas);
        self.shade_pass.draw(
            gpu,
            &mut encoder,
            &frame,
            gbuffer,
            &photographs,
            &tiles,
            &grid,
            maps,
            atlas,
            &targets.picture,
        );
        encoder.copy_buffer_to_buffer(&targets.picture, 0, &targets.readback, 0, None);
        gpu.queue.submit([encoder.finish()]);

        let stats = FrameStats {
            triangles: self.mesh.triangle_count(),
            triangles_drawn: drawn_mesh.triangle_count(),
            points: self.points.point_count(),
            points_drawn: points.points,
            points_refused: self.points.refused,
            images: self.photographs.len() as u64,
            images_drawn: photographs.len() as u64,
            ..FrameStats::default()
        };
        Ok(Frame::from_coded(size, read_back(gpu, &targets.readback)?, stats))
    }

    fn points_removed(&mut self, bounds: &Bounds3) {
        let margin_m = f64::from(self.settings.max_splat_radius_m);
        self.maps.points_removed(&self.photographs, bounds, margin_m);
    }

    /// The pinhole of the view's G-buffer, where view and device can have one.
    fn check(&self, view: &View) -> Result<Pinhole, RenderError> {
        let size: UVec2 = view.size();
        let max_side = self.gpu.device.limits().max_texture_dimension_2d;
        let pixels = u64::from(size.x) * u64::from(size.y);
        if pixels == 0 || pixels > MAX_PIXELS || size.max_element() > max_side {
            return Err(RenderError::ViewSize { size, max_side, max_pixels: MAX_PIXELS });
        }
        if let Some(what) = camera_fault(&view.camera) {
            return Err(RenderError::ViewCamera { what });
        }
        Pinhole::for_view(&view.camera.lens, max_side, MAX_PIXELS)
            .ok_or(RenderError::ViewCamera { what: "its lens sees nothing" })
    }
}

/// Waits for the device and copies the picture out.
fn read_back(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, RenderError> {
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
            let bytes = buffer
                .get_mapped_range(..)
                .map_err(|error| RenderError::Driver(error.to_string()))?
                .to_vec();
            buffer.unmap();
            Ok(bytes)
        }
        Ok(Err(error)) => Err(RenderError::Driver(error.to_string())),
        Err(error) => Err(RenderError::Driver(error.to_string())),
    }
}

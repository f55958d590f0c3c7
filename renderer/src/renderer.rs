//! What is resident, and the order of the passes that make a frame of it.

use flaneur_scene::{Bounds3, Distortion, PosedCamera, SceneUpdate, View, ViewProjection};
use glam::{DVec3, UVec2};

use crate::align::{self, AlignPass};
use crate::camera::gpu_data::Camera;
use crate::complete::{self, CompletePass};
use crate::depth_map::{DepthMaps, Sources};
use crate::forward::{ForwardPass, Indices};
use crate::frame::{Frame, FrameStats};
use crate::frustum::Frustum;
use crate::gains::Gains;
use crate::history::{Histories, History};
use crate::infer::{self, Evidence, InferPass};
use crate::mesh::{MeshPass, MeshStore};
use crate::photographs::{Crowded, PhotographStore, camera_fault};
use crate::pinhole::Pinhole;
use crate::points::{BLOCK_POINTS, DrawList, PointStore, Precedence};
use crate::shade::photograph::{Drawn, mark};
use crate::shade::{self, ShadePass};
use crate::splat::{SplatPass, ViewTarget};
use crate::stages::{PassTime, Stages};
use crate::surface::{Rays, SurfacePass};
use crate::targets::Targets;
use crate::tiles::{self, TilePass, Tiled};
use crate::{Applied, Gpu, Mode, RenderError, Settings, Texturing, depths, lens};

mod pick;
mod room;

use room::Picture;

/// Most pixels of a picture, and of the G-buffer behind it: a word each fits a storage
/// binding of 128 MiB.
pub(crate) const MAX_PIXELS: u64 = 1 << 25;

/// Holds a scene on the device and renders views of it.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    settings: Settings,
    mesh_pass: MeshPass,
    splat_pass: SplatPass,
    surface_pass: SurfacePass,
    tile_pass: TilePass,
    infer_pass: InferPass,
    align_pass: AlignPass,
    shade_pass: ShadePass,
    complete_pass: CompletePass,
    forward_pass: Option<ForwardPass>,
    mesh: MeshStore,
    points: PointStore,
    photographs: PhotographStore,
    maps: DepthMaps,
    gains: Gains,
    histories: Histories,
    targets: Option<Targets>,
    /// Where the next views are expected.
    eye: DVec3,
    /// The view of the last frame, at the size at which it was computed, and the size it was asked for.
    last: Option<(View, UVec2)>,
}

impl Renderer {
    /// An empty scene, with default settings.
    pub fn new(gpu: &Gpu) -> Self {
        Self::with_settings(gpu, Settings::default())
    }

    /// An empty scene. Settings outside their range are brought into it.
    pub fn with_settings(gpu: &Gpu, settings: Settings) -> Self {
        let settings = settings.in_range();
        Self {
            gpu: gpu.clone(),
            settings,
            mesh_pass: MeshPass::new(gpu),
            splat_pass: SplatPass::new(gpu, &settings),
            surface_pass: SurfacePass::new(gpu, settings.splat_normals),
            tile_pass: TilePass::new(gpu),
            infer_pass: InferPass::new(gpu),
            align_pass: AlignPass::new(gpu),
            shade_pass: ShadePass::new(gpu),
            complete_pass: CompletePass::new(gpu),
            forward_pass: ForwardPass::new(gpu, settings.texturing),
            mesh: MeshStore::default(),
            points: PointStore::new(settings.splat_normals),
            photographs: PhotographStore::new(gpu),
            maps: DepthMaps::new(gpu, &settings),
            gains: Gains::new(gpu),
            histories: Histories::default(),
            targets: None,
            eye: DVec3::ZERO,
            last: None,
        }
    }

    /// What it was told to do, brought into range.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Renders with other settings from now on; `false`, and no change, where points would need
    /// other radii or normals than those that they came with.
    ///
    /// Another [`depth_map_side`](Settings::depth_map_side),
    /// [`refine_by_points`](Settings::refine_by_points) or [`near_first`](Settings::near_first) has
    /// all depth maps drawn anew; another [`texturing`](Settings::texturing),
    /// [`resolution`](Settings::resolution), [`splat_route`](Settings::splat_route) or
    /// [`quads_from_px`](Settings::quads_from_px) has what pictures are drawn into made anew; anything
    /// else costs nothing.
    pub fn set_settings(&mut self, settings: Settings) -> bool {
        let before = self.settings;
        let settings = settings.in_range();
        if !settings.keep_points(&before) {
            return false;
        }
        self.settings = settings;
        if settings.texturing != before.texturing {
            self.forward_pass = ForwardPass::new(&self.gpu, settings.texturing);
        }
        if !settings.keep_maps(&before) {
            self.photographs.set_map_side(settings.depth_map_side);
            self.maps = DepthMaps::new(&self.gpu, &settings);
            self.gains.forget();
            self.histories.clear();
        }
        if (settings.splat_route, settings.quads_from_px)
            != (before.splat_route, before.quads_from_px)
        {
            self.splat_pass.set_route(&self.gpu, &settings);
            self.targets = None;
        }
        true
    }

    /// Says that the next frame does not follow the last, as where a film is cut: nothing goes
    /// from one to the other smoothly. A view that jumps does the same by itself.
    pub fn cut(&mut self) {
        self.gains.cut();
        self.infer_pass.cut();
    }

    /// Says who looks at the next frames: what goes from frame to frame smoothly goes on from their
    /// last one, whoever had turns meanwhile. Without it all frames are of one viewer, 0. Of those who
    /// looked last 64 are remembered, as far as there is room.
    pub fn look_as(&mut self, viewer: u64) {
        if self.histories.is_other(viewer) {
            let (gains, inferred) =
                (self.gains.exchange(Default::default()), self.infer_pass.exchange(None));
            let own = self.histories.turn(viewer, History { gains, inferred });
            self.gains.exchange(own.gains);
            self.infer_pass.exchange(own.inferred);
        }
    }

    /// Forgets a viewer who looks no more.
    pub fn forget_viewer(&mut self, viewer: u64) {
        if self.histories.is_other(viewer) {
            self.histories.forget(viewer);
        } else {
            self.cut();
        }
    }

    /// Changes what is resident. Dropping what is not there is no error.
    ///
    /// Triangles and points that are not finite are left out, and counted in
    /// [`FrameStats::triangles_refused`] and [`FrameStats::points_refused`].
    ///
    /// # Errors
    /// Where the update contradicts itself, or exceeds what the device takes in one piece; what is
    /// resident then stays as it was.
    pub fn apply(&mut self, update: SceneUpdate) -> Result<Applied, RenderError> {
        self.gpu.clone().watched(|| self.change(update))
    }

    fn change(&mut self, update: SceneUpdate) -> Result<Applied, RenderError> {
        let mut applied = Applied::default();
        let (shares, eye) = (self.settings.shares(), self.eye);
        match update {
            SceneUpdate::Mesh(tile) => {
                let mut evicted = Vec::new();
                let changed = self.mesh.insert(&self.gpu, &tile, shares.mesh, eye, &mut evicted)?;
                self.maps.mesh_changed(&self.photographs, &changed);
                for (key, bounds) in evicted {
                    self.maps.mesh_changed(&self.photographs, &bounds);
                    applied.refused |= key == tile.key;
                    applied.evicted.push(SceneUpdate::DropMesh(key));
                }
            }
            SceneUpdate::DropMesh(key) => {
                let changed = self.mesh.remove(key);
                self.maps.mesh_changed(&self.photographs, &changed);
            }
            SceneUpdate::Points(chunk) => {
                let change = self.points.insert(&self.gpu, &self.settings, &chunk, eye)?;
                self.points_removed(&change.removed);
                let id = chunk.id;
                for (id, bounds) in change.evicted {
                    self.points_removed(&bounds);
                    applied.evicted.push(SceneUpdate::DropPoints(id));
                }
                if change.refused {
                    applied.refused = true;
                    applied.evicted.push(SceneUpdate::DropPoints(id));
                }
                let margin_m = f64::from(self.settings.max_splat_radius_m);
                self.maps.points_added(&self.photographs, id, &change.added, margin_m);
            }
            SceneUpdate::DropPoints(id) => {
                let removed = self.points.remove(id);
                self.points_removed(&removed);
            }
            SceneUpdate::Image(image) => {
                let mut crowded = Crowded::default();
                let (gpu, settings) = (&self.gpu, &self.settings);
                if self.photographs.insert(gpu, settings, &image, eye, &mut crowded)? {
                    self.maps.forget(&image.id);
                }
                applied.refused = crowded.refused;
                if crowded.refused {
                    crowded.coarser.insert(image.id.clone());
                }
                for id in crowded.coarser {
                    match self.photographs.level(&id) {
                        Some(level) => applied.coarser.push((id, level)),
                        None => applied.evicted.push(SceneUpdate::DropImage(id)),
                    }
                }
                for id in crowded.evicted {
                    self.maps.forget(&id);
                    applied.evicted.push(SceneUpdate::DropImage(id));
                }
            }
            SceneUpdate::DropImage(id) => {
                self.photographs.remove(&id);
                self.maps.forget(&id);
            }
        }
        self.yield_room();
        Ok(applied)
    }

    /// Says where the next views will be, world, metres: what is far from there is given up first
    /// where memory is short. Until it is said, the eye of the last frame counts.
    pub fn expect_eye(&mut self, eye: DVec3) {
        self.eye = eye;
    }

    /// The picture that the view's camera would take of what is resident.
    ///
    /// # Errors
    /// Where the view's camera or size cannot be used, or the driver fails.
    pub fn render(&mut self, view: &View) -> Result<Frame, RenderError> {
        self.render_as(view, Mode::Hybrid)
    }

    /// The same in another mode.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_as(&mut self, view: &View, mode: Mode) -> Result<Frame, RenderError> {
        let stages = Stages::untimed(&self.gpu);
        self.gpu.clone().watched(|| self.draw(view, mode, stages)).map(|(frame, _)| frame)
    }

    /// The frame, and how long each pass took: each is waited for before the next begins, so
    /// that together they take longer than a frame.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_timed(
        &mut self,
        view: &View,
        mode: Mode,
    ) -> Result<(Frame, Vec<PassTime>), RenderError> {
        let stages = Stages::timed(&self.gpu);
        self.gpu.clone().watched(|| self.draw(view, mode, stages))
    }

    fn draw(
        &mut self,
        view: &View,
        mode: Mode,
        mut stages: Stages,
    ) -> Result<(Frame, Vec<PassTime>), RenderError> {
        let whole_size = view.size();
        self.check(view)?;
        let view = &reduced(view, self.settings.resolution);
        let pinhole = self.check(view)?;
        let size = view.size();
        let eye = view.eye();
        self.eye = eye;
        let camera = Camera::of_view(view, &pinhole);
        let frustum = Frustum::of_view(view, &pinhole);
        let max_side = self.gpu.device.limits().max_texture_dimension_2d;
        let perspective = camera.orthographic == 0;
        let inferring = (self.settings.infer && infers(mode) && perspective)
            .then(|| infer::Grid::new(size, self.settings.inferred_hypotheses, max_side))
            .flatten();
        let completing =
            inferring.filter(|_| completes(mode)).and_then(|_| complete::grid(size, max_side));
        // Sprites bring their own projections, which know of no displacement.
        let deferred = self.settings.texturing == Texturing::Deferred;
        let aligning = self.settings.align && deferred && perspective;
        let sprite_room = self.make_room(&Picture {
            gbuffer: pinhole.size,
            size,
            inferring,
            completing,
            aligning: aligning.then(|| infer::Grid::alone(size, max_side)).flatten(),
            frustum: &frustum,
            eye,
        })?;
        let (gpu, settings) = (&self.gpu, &self.settings);
        self.points.upload(gpu);
        let route = self.splat_pass.route(gpu, pixels(pinhole.size));
        let targets =
            self.targets.get_or_insert_with(|| Targets::new(gpu, pinhole.size, size, route));
        stages.ended("upload")?;

        let selected = self.photographs.select(&frustum, eye, settings.rigs, self.maps.max_maps());
        let sources = Sources {
            mesh_pass: &self.mesh_pass,
            splat_pass: &self.splat_pass,
            mesh: &self.mesh,
            points: &self.points,
        };
        let mapped: Vec<_> =
            selected.iter().map(|(id, photograph, _)| (*id, *photograph)).collect();
        self.maps.prepare(gpu, stages.encoder(), &sources, &mapped);
        stages.ended("depth maps")?;
        if settings.exposure_gains {
            let (maps, atlas) = (&self.maps, &self.photographs.atlas);
            self.gains.update(gpu, &mut stages, &selected, maps, atlas, &view.camera)?;
            stages.ended("gains")?;
        }

        let mut drawn_mesh = self.mesh.draw_list(gpu, &frustum, eye);
        if matches!(mode, Mode::Points | Mode::PointsColour) {
            drawn_mesh.clear();
        }
        self.mesh_pass.draw_gbuffer(
            gpu,
            stages.encoder(),
            &camera,
            &drawn_mesh,
            mode == Mode::Wireframe,
            &targets.planes,
            &targets.surfaces,
            &targets.depth,
        );
        stages.ended("mesh")?;

        let precedence = if settings.near_first { Precedence::View } else { Precedence::None };
        let mut points = self.points.view_list(&frustum, eye, settings.points_share, precedence);
        if mode == Mode::Mesh {
            points = DrawList::default();
        }
        let target = ViewTarget {
            nearest: &targets.nearest_points,
            winners: &targets.winners,
            winning_normals: &targets.winning_normals,
            canvas: &targets.canvas,
        };
        let store = &self.points;
        self.splat_pass.draw_view(gpu, stages.encoder(), store, &points, &camera, target);
        stages.ended("points")?;
        // A device that begins now works while the rest is recorded.
        stages.submit();

        let lens = lens::gpu_data::Lens::new(&view.camera.lens);
        let distorted = lens.model != 0;
        let rays = Rays::new(gpu, camera, &view.camera.lens);
        self.surface_pass.draw(gpu, stages.encoder(), &rays, targets);
        stages.ended("surface")?;

        let drawn: Vec<((&Frustum, usize), Drawn)> = selected
            .iter()
            .filter_map(|(id, photograph, standing)| {
                let map = self.maps.place(id)?;
                let gain = if settings.exposure_gains { self.gains.of(id) } else { [1.0; 3] };
                let mark = mark(id);
                let drawn = Drawn::new(photograph, eye, *standing, map, gain, mark);
                Some(((&photograph.frustum, standing.rig), drawn))
            })
            .collect();
        let (seen, mut photographs): (Vec<_>, Vec<Drawn>) = drawn.into_iter().unzip();
        let frame = shade::gpu_data::Frame {
            forward: camera.forward,
            focal: lens.focal[1],
            background: settings.background.map(|c| f32::from(c) / 255.0),
            orthographic: camera.orthographic,
            size: size.as_vec2().to_array(),
            mode: mode as u32,
            depth_test: u32::from(settings.depth_test),
        };
        let bounds = self.mesh.bounds().union(&self.points.bounds());
        let evidence = Evidence {
            view,
            frame: &frame,
            rays: &rays,
            photographs: &photographs,
            frustums: &seen,
            atlas: &self.photographs.atlas,
            extent_m: farthest(&bounds, eye),
        };
        if let Some(cells) = inferring {
            self.infer_pass.draw(gpu, stages.encoder(), &self.tile_pass, evidence, cells, targets);
            stages.ended("infer")?;
        }
        let shown = tiles::Shown { view, size, positions: &targets.records.positions };
        let boxes = self.tile_pass.boxes(gpu, stages.encoder(), shown);
        let tiles = Tiled { pass: &self.tile_pass, boxes: &boxes };
        stages.ended("tiles")?;
        if aligning {
            let align = &mut self.align_pass;
            let shares = align.draw(gpu, stages.encoder(), tiles, evidence, &self.maps, targets);
            if let Some(shares) = shares {
                align::share_out(&mut photographs, shares, align.step());
            }
            stages.ended("align")?;
        }

        let (words, stride) = targets.nearest_points.indices();
        let indices =
            Indices { words, stride, end: points.blocks.len() as u64 * BLOCK_POINTS as u64 };
        let sprites = self.forward_pass.as_mut().and_then(|pass| {
            let encoder = stages.encoder();
            pass.gather(gpu, encoder, &camera, distorted, indices, targets, sprite_room)
        });
        if self.settings.texturing != Texturing::Deferred {
            stages.ended("sprites")?;
        }

        let sources = shade::Sources {
            photographs: &photographs,
            seen: &seen,
            tiles,
            maps: &self.maps,
            offsets: self.align_pass.offsets(),
            atlas: &self.photographs.atlas,
            sprites: sprites.as_ref(),
        };
        self.shade_pass.draw_photographs(gpu, stages.encoder(), &frame, sources, targets);
        stages.ended("photographs")?;
        let shown = complete::Shown {
            positions: &targets.records.positions,
            orientations: &targets.records.orientations,
            blended: &targets.blended,
        };
        let completion = self.complete_pass.draw(gpu, stages.encoder(), completing, shown);
        if completing.is_some() {
            stages.ended("complete")?;
        }
        self.shade_pass.compose(gpu, stages.encoder(), &frame, &completion, targets);
        stages.ended("compose")?;
        targets.copy_picture(stages.encoder());
        stages.submit();

        let stats = FrameStats {
            triangles: self.mesh.triangle_count(),
            triangles_drawn: drawn_mesh.triangle_count(),
            points: self.points.point_count(),
            points_drawn: points.points,
            triangles_refused: self.mesh.refused,
            points_refused: self.points.refused,
            images: self.photographs.len() as u64,
            images_drawn: photographs.len() as u64,
            ..FrameStats::default()
        };
        let frame = Frame::from_coded(size, targets.read_picture(gpu)?, stats);
        let frame = frame.enlarged(whole_size);
        stages.ended("read back")?;
        self.last = Some((*view, whole_size));
        Ok((frame, stages.times()))
    }

    /// How far away each pixel of the last frame is, along the view's axis, metres; `None` where
    /// no surface is known. Rows from the top, of the size at which the frame was computed; empty
    /// before the first frame.
    ///
    /// # Errors
    /// Where the driver fails.
    pub fn last_depths(&self) -> Result<Vec<Option<f32>>, RenderError> {
        match (&self.targets, &self.last) {
            (Some(targets), Some((view, _))) => {
                depths::read(&self.gpu, &targets.records.positions, view.camera.forward())
            }
            _ => Ok(Vec::new()),
        }
    }

    /// What the last frame shows, see surface/place.wgsl.
    #[cfg(test)]
    pub(crate) fn last_positions(&self) -> Option<&wgpu::TextureView> {
        self.targets.as_ref().map(|targets| &targets.records.positions)
    }

    /// Where the last frame inferred its pixels without geometry to be.
    #[cfg(test)]
    pub(crate) fn infer_pass(&self) -> &InferPass {
        &self.infer_pass
    }

    /// How the photographs of the last frame were made to agree.
    #[cfg(test)]
    pub(crate) fn align_pass(&self) -> &AlignPass {
        &self.align_pass
    }

    /// The factors of a photograph's linear colours in the last frame.
    #[cfg(test)]
    pub(crate) fn last_gain(&self, id: &flaneur_scene::ImageId) -> DVec3 {
        DVec3::from_array(self.gains.of(id).map(f64::from))
    }

    fn points_removed(&mut self, bounds: &Bounds3) {
        let margin_m = f64::from(self.settings.max_splat_radius_m);
        self.maps.points_removed(&self.photographs, bounds, margin_m);
    }

    /// The pinhole of the view's G-buffer, where view and device can have one.
    fn check(&self, view: &View) -> Result<Pinhole, RenderError> {
        let size: UVec2 = view.size();
        let max_side = self.gpu.device.limits().max_texture_dimension_2d;
        let pixels = pixels(size);
        if pixels == 0 || pixels > MAX_PIXELS || size.max_element() > max_side {
            return Err(RenderError::ViewSize { size, max_side, max_pixels: MAX_PIXELS });
        }
        if let Some(what) = camera_fault(&view.camera) {
            return Err(RenderError::ViewCamera { what });
        }
        let distorted = view.camera.lens.distortion != Distortion::None;
        if distorted && view.projection == ViewProjection::Orthographic {
            return Err(RenderError::ViewCamera { what: "an orthographic view has a distortion" });
        }
        Pinhole::for_view(&view.camera.lens, max_side, MAX_PIXELS)
            .ok_or(RenderError::ViewCamera { what: "its lens sees nothing" })
    }
}

/// The view at a share of its size, at least a pixel; its lens sees the same.
fn reduced(view: &View, share: f32) -> View {
    if share >= 1.0 {
        return *view;
    }
    let size = (view.size().as_dvec2() * f64::from(share)).round().as_uvec2().max(UVec2::ONE);
    let camera = &view.camera;
    View { camera: PosedCamera { lens: camera.lens.scaled_to(size), ..*camera }, ..*view }
}

fn pixels(size: UVec2) -> u64 {
    u64::from(size.x) * u64::from(size.y)
}

/// Whether a mode shows what is inferred where there is no geometry.
fn infers(mode: Mode) -> bool {
    matches!(mode, Mode::Hybrid | Mode::Sources | Mode::Uncertainty)
}

/// Whether a mode shows colours from around where nothing has any.
fn completes(mode: Mode) -> bool {
    matches!(mode, Mode::Hybrid | Mode::Uncertainty)
}

/// From `eye` to the farthest of `bounds`, metres; 0 where those are empty.
fn farthest(bounds: &Bounds3, eye: DVec3) -> f64 {
    let farthest = (bounds.min - eye).abs().max((bounds.max - eye).abs()).length();
    if farthest.is_finite() { farthest } else { 0.0 }
}

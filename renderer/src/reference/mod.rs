//! Whole frames in f64 on the CPU, for measuring what the device gets wrong.
//!
//! A [`Scene`] takes the same updates as a [`crate::Renderer`] and renders the same views, but
//! asks one ray a pixel, through the view's own lens, which triangle and which disc it meets
//! first. It is written from the equations, in the per-pass references where those exist, and
//! shares with the device only what is a definition rather than a computation: the stored sizes
//! of points, the texel grids of depth maps, the photographs' levels as bytes. It is slow and
//! meant for small scenes.
//!
//! ```
//! use flaneur_renderer::{Mode, Settings, reference};
//! use flaneur_scene::View;
//! use glam::{DVec3, UVec2};
//!
//! let scene = reference::Scene::new(Settings::default());
//! // scene.apply(update) for each `SceneUpdate` that a renderer accepted
//! let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::new(8, 6));
//! let frame = scene.render(&view, Mode::Hybrid);
//! assert!(frame.pixels.iter().all(|pixel| pixel.place.is_none()));
//! ```
//!
//! Frames follow no other: exposure gains are those to which photographs on display would go over
//! some frames.
//!
//! Not part of it: colours inferred where there is no geometry (switch that off to compare), and the
//! lines of [`Mode::Wireframe`], which are a pixel of the device's raster wide.

use std::collections::BTreeMap;
use std::sync::Arc;

use flaneur_scene::{
    ImageId, ImageUpdate, MeshTile, PointChunk, PointNodeId, SceneUpdate, TileKey, View,
    ViewProjection,
};
use glam::{DVec3, UVec2};

#[cfg(test)]
use crate::align::reference::Level;
use crate::{Mode, Settings, Surface};

mod alignment;
mod boxes;
mod colour;
mod difference;
mod discs;
mod exposure;
pub(crate) mod field;
mod photograph;
mod pyramid;
mod rigs;
mod surfaces;
#[cfg(test)]
mod tests;
mod triangles;

pub use difference::Difference;

use alignment::Aligned;
use rigs::Rigs;
use triangles::Triangles;

/// What a reference frame is made of. Updates that a renderer refuses must be kept from it.
#[derive(Clone, Debug)]
pub struct Scene {
    settings: Settings,
    mesh: BTreeMap<TileKey, Arc<MeshTile>>,
    points: BTreeMap<PointNodeId, Arc<PointChunk>>,
    images: BTreeMap<ImageId, Arc<ImageUpdate>>,
}

/// A picture, pixel by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceFrame {
    /// Size in pixels.
    pub size: UVec2,
    /// Rows from the top.
    pub pixels: Vec<Pixel>,
}

/// One pixel of a [`ReferenceFrame`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// sRGB, 0 to 1.
    pub rgb: DVec3,
    /// What it shows.
    pub surface: Surface,
    /// Where that is; `None` for [`Surface::Background`].
    pub place: Option<Place>,
    /// Direction that the pixel sees, world axes, of depth 1 along the view's axis; zero where
    /// its lens sees nothing.
    pub ray: DVec3,
}

/// Where a surface is that a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Relative to the eye, metres, world axes.
    pub position: DVec3,
    /// Along the view's axis, metres.
    pub depth_m: f64,
    /// Unit, towards the eye, world axes.
    pub normal: DVec3,
}

/// Of depth 1 along the camera's axis at parameter 1.
#[derive(Clone, Copy, Debug)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
}

impl Scene {
    /// An empty scene. Settings outside their range are brought into it.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings: settings.in_range(),
            mesh: BTreeMap::new(),
            points: BTreeMap::new(),
            images: BTreeMap::new(),
        }
    }

    /// Changes what the scene holds.
    pub fn apply(&mut self, update: SceneUpdate) {
        match update {
            SceneUpdate::Mesh(tile) => drop(self.mesh.insert(tile.key, tile)),
            SceneUpdate::DropMesh(key) => drop(self.mesh.remove(&key)),
            SceneUpdate::Points(chunk) => drop(self.points.insert(chunk.id, chunk)),
            SceneUpdate::DropPoints(id) => drop(self.points.remove(&id)),
            SceneUpdate::Image(image) => drop(self.images.insert(image.id.clone(), image)),
            SceneUpdate::DropImage(id) => drop(self.images.remove(&id)),
        }
    }

    /// How bright each of the two nearest rigs shows the cells of the levels on which they are
    /// aligned, finest first, and what comes of it.
    #[cfg(test)]
    fn aligned(&self, view: &View) -> Option<(Vec<Level>, Aligned)> {
        let mesh = Triangles::new(self.mesh.values());
        let points = discs::points(&self.points, &self.settings);
        let rigs = Rigs::new(&self.images, view, &self.settings, &mesh, &points);
        let shown = surfaces::shown(view, Mode::Hybrid, &mesh, &points);
        let aligned = Aligned::new(view, &rigs, &shown)?;
        Some((alignment::levels(view, &rigs, &shown), aligned))
    }

    /// The factors of each photograph's linear colours in the picture of a view.
    #[cfg(test)]
    fn gains(&self, view: &View) -> Vec<(ImageId, DVec3)> {
        let mesh = Triangles::new(self.mesh.values());
        let points = discs::points(&self.points, &self.settings);
        Rigs::new(&self.images, view, &self.settings, &mesh, &points).gains()
    }

    /// The picture of a view that a renderer accepts.
    pub fn render(&self, view: &View, mode: Mode) -> ReferenceFrame {
        let mesh = Triangles::new(self.mesh.values());
        let points = discs::points(&self.points, &self.settings);
        let rigs = Rigs::new(&self.images, view, &self.settings, &mesh, &points);
        let shown = surfaces::shown(view, mode, &mesh, &points);
        let aligned = (self.settings.align && view.projection == ViewProjection::Perspective)
            .then(|| Aligned::new(view, &rigs, &shown))
            .flatten();
        let painter = Painter {
            view,
            mode,
            background: DVec3::from_array(self.settings.background.map(|c| f64::from(c) / 255.0)),
            rigs: &rigs,
            aligned: aligned.as_ref(),
        };
        let pixels = field::cells(shown.size).map(|at| painter.pixel(at, &shown.at(at)));
        ReferenceFrame { size: view.size(), pixels: pixels.collect() }
    }
}

/// What colours the pixels of a view.
struct Painter<'a> {
    view: &'a View,
    mode: Mode,
    background: DVec3,
    rigs: &'a Rigs<'a>,
    aligned: Option<&'a Aligned>,
}

impl Painter<'_> {
    fn pixel(&self, at: UVec2, pixel: &surfaces::Pixel) -> Pixel {
        let ray = pixel.ray;
        let Some(met) = &pixel.met else {
            let (rgb, surface) = (self.background, Surface::Background);
            return Pixel { rgb, surface, place: None, ray };
        };
        let (depth_m, normal) = (met.shown.depth_m, met.shown.normal);
        let pixels_per_m = self.view.pixels_a_metre(depth_m);
        let moves = self.aligned.map(|aligned| aligned.moves(at.as_dvec2() + 0.5, depth_m));
        let position = self.view.eye() + met.position;
        let blend = self.rigs.blend(position, &met.shown, pixels_per_m, moves);
        let surface = match (met.shown.is_point, blend.is_some()) {
            (false, false) => Surface::MeshUncoloured,
            (false, true) => Surface::MeshColoured,
            (true, false) => Surface::PointUncoloured,
            (true, true) => Surface::PointColoured,
        };
        let what = met.what;
        let rgb = colour::colour(&colour::Pixel { depth_m, normal, what, blend }, self.mode);
        let place = Some(Place { position: met.position, depth_m, normal });
        Pixel { rgb, surface, place, ray }
    }
}

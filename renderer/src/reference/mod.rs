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
//! Not part of it: the lines of [`Mode::Wireframe`], which are a pixel of the device's raster wide;
//! [`Settings::points_share`] and [`Settings::resolution`], which say what a frame may leave out for
//! speed: the reference leaves nothing out, whatever they are. [`Settings::texturing`],
//! [`Settings::splat_route`] and [`Settings::quads_from_px`] are ways to one picture, which is this one.

use std::collections::BTreeMap;
use std::sync::Arc;

use flaneur_scene::{
    ImageId, ImageUpdate, MeshTile, PointChunk, PointNodeId, SceneUpdate, SurfaceClass, TileKey,
    View, ViewProjection, linear_from_srgb,
};
use glam::{DVec3, UVec2};

#[cfg(test)]
use crate::align::reference::Level;
use crate::shade::reference::INFERRED_OFF;
use crate::{Mode, Settings, Surface};

mod alignment;
mod boxes;
mod colour;
mod completion;
mod difference;
mod discs;
mod exposure;
pub(crate) mod field;
mod inference;
mod photograph;
mod pyramid;
mod rigs;
mod surfaces;
mod taken;
#[cfg(test)]
mod tests;
mod triangles;

pub use difference::Difference;

use alignment::Aligned;
use colour::What;
use completion::{Beside, Coloured, Completion};
use discs::Point;
use field::Field;
use inference::{Hypotheses, Inferred};
use rigs::{Blend, Rigs};
use triangles::Triangles;

/// By how much a device's costs of two hypotheses may differ otherwise than in f64, in brightness:
/// software devices decode photographs with an error of a third of a byte, which is 1.3e-3 of a middle
/// grey, but nearly the same for both rigs and over a window, and costs are kept in 11 bits.
const COST_NOISE: f64 = 3e-4;

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
    /// Where that is; `None` for [`Surface::Background`], [`Surface::Inferred`] and
    /// [`Surface::Completed`].
    pub place: Option<Place>,
    /// Direction that the pixel sees, world axes, of depth 1 along the view's axis; zero where
    /// its lens sees nothing.
    pub ray: DVec3,
    /// Share by which the depth of an inferred pixel may be another one where the photographs'
    /// brightnesses are rounded as a device does, or, if that is more, the depths of those whose
    /// colours it takes; 0 elsewhere.
    pub doubt: f64,
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

    /// What is inferred for the picture of a view, and what each rig that is asked shows of a
    /// hypothesis of each cell.
    #[cfg(test)]
    fn inference(&self, view: &View) -> Option<(Hypotheses, Vec<Vec<inference::Sights>>)> {
        let mesh = Triangles::new(self.mesh.values());
        let points = discs::points(&self.points, &self.settings);
        let rigs = Rigs::new(&self.images, view, &self.settings, &mesh, &points);
        let shown = surfaces::shown(view, Mode::Hybrid, &mesh, &points);
        let hypotheses = self.hypotheses(view, &shown, &mesh, &points)?;
        let sights = hypotheses.sights(view, &rigs);
        Some((hypotheses, sights))
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
        let geometry = surfaces::shown(view, mode, &mesh, &points);
        let perspective = view.projection == ViewProjection::Perspective;
        let inferred = (self.settings.infer && perspective && infers(mode))
            .then(|| self.hypotheses(view, &geometry, &mesh, &points))
            .flatten()
            .map(|hypotheses| {
                hypotheses.inferred(&hypotheses.sights(view, &rigs), None, COST_NOISE)
            });
        let shown = match &inferred {
            Some(all) => Field::new(geometry.size, |at| all.filled(view, at, geometry.at(at))),
            None => geometry,
        };
        let aligned = (self.settings.align && perspective)
            .then(|| Aligned::new(view, &rigs, &shown))
            .flatten();
        let painter = Painter {
            view,
            mode,
            background: DVec3::from_array(self.settings.background.map(|c| f64::from(c) / 255.0)),
            rigs: &rigs,
            aligned: aligned.as_ref(),
            inferred: inferred.as_ref(),
        };
        let blends = Field::new(shown.size, |at| painter.blend(at, &shown.at(at)));
        let completions = painter.completions(&shown, &blends);
        let pixels = field::cells(shown.size)
            .map(|at| painter.pixel(at, &shown.at(at), blends.at(at), &completions));
        ReferenceFrame { size: view.size(), pixels: pixels.collect() }
    }
}

impl Scene {
    /// Where pixels of a view that show no geometry may be.
    fn hypotheses(
        &self,
        view: &View,
        shown: &Field<surfaces::Pixel>,
        mesh: &Triangles,
        points: &[Point],
    ) -> Option<Hypotheses> {
        let mut bounds = mesh.bounds();
        points.iter().for_each(|point| bounds.include(point.position));
        let corners = [bounds.min, bounds.max].map(|corner| (corner - view.eye()).abs());
        let extent_m = corners[0].max(corners[1]).length();
        let extent_m = if extent_m.is_finite() { extent_m } else { 0.0 };
        Hypotheses::new(view, shown, extent_m, self.settings.inferred_hypotheses)
    }
}

/// Whether a mode shows what is inferred where there is no geometry.
fn infers(mode: Mode) -> bool {
    matches!(mode, Mode::Hybrid | Mode::Sources | Mode::Uncertainty)
}

/// Whether a mode shows colours from around where nothing has any.
fn completes(mode: Mode) -> bool {
    matches!(mode, Mode::Hybrid | Mode::Uncertainty)
}

/// Colours for what no photograph reaches, where its kind has any.
#[derive(Default)]
struct Completions {
    inferred: Option<Completion>,
    ground: Option<Completion>,
    surfaces: Option<Beside>,
}

/// What colours the pixels of a view.
struct Painter<'a> {
    view: &'a View,
    mode: Mode,
    background: DVec3,
    rigs: &'a Rigs<'a>,
    aligned: Option<&'a Aligned>,
    inferred: Option<&'a Inferred>,
}

impl Painter<'_> {
    /// What the photographs say together about what a pixel shows.
    fn blend(&self, at: UVec2, pixel: &surfaces::Pixel) -> Option<Blend> {
        let met = pixel.met.as_ref()?;
        let depth_m = met.shown.depth_m;
        let pixels_per_m = self.view.pixels_a_metre(depth_m);
        let moves = self.aligned.map(|aligned| aligned.moves(at.as_dvec2() + 0.5, depth_m));
        let position = self.view.eye() + met.position;
        self.rigs.blend(position, &met.shown, share_off(met), pixels_per_m, moves)
    }

    /// Colours for the pixels without one, inferred or ground, from those of their kind that have one.
    fn completions(
        &self,
        shown: &Field<surfaces::Pixel>,
        blends: &Field<Option<Blend>>,
    ) -> Completions {
        let Some(inferred) = self.inferred.filter(|_| completes(self.mode)) else {
            return Completions::default();
        };
        let of = |is_of_kind: fn(&surfaces::Pixel) -> bool, doubt: &dyn Fn(UVec2) -> f64| {
            let coloured = Field::new(shown.size, |at| {
                let blend = blends.at(at).filter(|_| is_of_kind(&shown.at(at)))?;
                Some(Coloured { colour: blend.colour, doubt: doubt(at) })
            });
            Completion::new(self.view, &coloured)
        };
        Completions {
            inferred: of(is_inferred, &|at| inferred.doubt(at)),
            ground: of(is_ground, &|_| 0.0),
            surfaces: Beside::new(
                self.view,
                &Field::new(shown.size, |at| {
                    blends.at(at).filter(|_| !is_inferred(&shown.at(at))).map(|blend| blend.colour)
                }),
            ),
        }
    }

    fn pixel(
        &self,
        at: UVec2,
        pixel: &surfaces::Pixel,
        blend: Option<Blend>,
        completions: &Completions,
    ) -> Pixel {
        let ray = pixel.ray;
        let nothing = |doubt| Pixel {
            rgb: self.background,
            surface: Surface::Background,
            place: None,
            ray,
            doubt,
        };
        let Some(met) = &pixel.met else {
            return nothing(0.0);
        };
        let is_inferred = is_inferred(pixel);
        let inferred = self.inferred.filter(|_| is_inferred);
        let mut doubt = inferred.map_or(0.0, |inferred| inferred.doubt(at));
        let (depth_m, normal) = (met.shown.depth_m, met.shown.normal);
        let (mut what, mut blend) = (met.what, blend);
        let surface = match (met.shown.is_point, blend.is_some()) {
            (_, true) if is_inferred => Surface::Inferred,
            (_, false) if is_inferred => {
                // Without any colour it is nothing.
                let Some(around) = &completions.inferred else { return nothing(doubt) };
                let Coloured { colour, doubt: of_colour } = around.at(at);
                doubt = doubt.max(of_colour);
                what = What::Completed;
                blend = Some(Blend::of_colour(colour));
                Surface::Completed
            }
            (false, false) => {
                // Its doubt stays dark.
                let shown = is_ground(pixel) && self.mode == Mode::Hybrid;
                let around = completions.ground.as_ref().filter(|_| shown);
                blend = around.map(|around| around.at(at).colour).map(Blend::of_colour);
                Surface::MeshUncoloured
            }
            (false, true) => Surface::MeshColoured,
            (true, false) => {
                let around = completions.surfaces.as_ref();
                blend = around.filter(|_| self.mode == Mode::Hybrid).map(|around| {
                    let own =
                        colour::colour(&colour::Pixel { depth_m, normal, what, blend }, self.mode);
                    Blend::of_colour(around.mixed(at, own.map(linear_from_srgb)))
                });
                Surface::PointUncoloured
            }
            (true, true) => Surface::PointColoured,
        };
        let rgb = colour::colour(&colour::Pixel { depth_m, normal, what, blend }, self.mode);
        // Nothing may be measured at what is inferred.
        let place = (!is_inferred).then_some(Place { position: met.position, depth_m, normal });
        Pixel { rgb, surface, place, ray, doubt }
    }
}

/// Share of its distance from the eye by which what a pixel shows may be off.
fn share_off(met: &surfaces::Met) -> f64 {
    match met.what {
        What::Inferred => INFERRED_OFF,
        What::Mesh { .. } | What::Point { .. } | What::Completed => 0.0,
    }
}

fn is_ground(pixel: &surfaces::Pixel) -> bool {
    pixel.met.is_some_and(|met| matches!(met.what, What::Mesh { class: SurfaceClass::Ground, .. }))
}

fn is_inferred(pixel: &surfaces::Pixel) -> bool {
    pixel.met.is_some_and(|met| matches!(met.what, What::Inferred))
}

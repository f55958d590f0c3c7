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
//! Not part of it: colours inferred where there is no geometry, the alignment of photographs (switch
//! both off to compare), and the lines of [`Mode::Wireframe`], which are a pixel of the device's raster wide.

use std::collections::BTreeMap;
use std::sync::Arc;

use flaneur_scene::{
    Distortion, ImageId, ImageUpdate, MeshTile, PointChunk, PointNodeId, SceneUpdate, TileKey,
    View, ViewProjection,
};
use glam::{DVec2, DVec3, UVec2};

use crate::camera::nearest_depth;
use crate::pinhole::MAX_TANGENT;
use crate::surface::reference::{self as hybrid, DiscHit, MeshHit};
use crate::{Mode, Settings, Surface};

mod boxes;
mod colour;
mod difference;
mod discs;
mod exposure;
mod photograph;
mod pyramid;
mod rigs;
mod srgb;
#[cfg(test)]
mod tests;
mod triangles;

pub use difference::Difference;

use colour::What;
use discs::{Discs, Point, Target};
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
        let camera = &view.camera;
        let intrinsics = camera.lens.intrinsics;
        let focal = intrinsics.fx.min(intrinsics.fy);
        let drawn: &[Point] = if mode == Mode::Mesh { &[] } else { &points };
        let eye = Eye {
            view,
            mode,
            background: DVec3::from_array(self.settings.background.map(|c| f64::from(c) / 255.0)),
            mesh: (!matches!(mode, Mode::Points | Mode::PointsColour)).then_some(&mesh),
            points: &points,
            discs: Discs::new(drawn, camera, focal, Target::View(view.projection)),
            rigs: Rigs::new(&self.images, view, &self.settings, &mesh, &points),
        };
        let UVec2 { x: columns, y: rows } = view.size();
        let pixels = (0..rows)
            .flat_map(|y| (0..columns).map(move |x| UVec2::new(x, y).as_dvec2() + 0.5))
            .map(|pixel| eye.pixel(pixel))
            .collect();
        ReferenceFrame { size: view.size(), pixels }
    }
}

/// Everything that one view sees.
struct Eye<'a> {
    view: &'a View,
    mode: Mode,
    background: DVec3,
    mesh: Option<&'a Triangles>,
    points: &'a [Point],
    discs: Discs,
    rigs: Rigs<'a>,
}

impl Eye<'_> {
    fn pixel(&self, pixel: DVec2) -> Pixel {
        let Some(in_camera) = self.ray(pixel) else {
            return self.nothing(DVec3::ZERO);
        };
        let eye = self.view.eye();
        let world_from_cam = self.view.camera.cam_from_world.transpose();
        let origin = world_from_cam * in_camera.origin;
        let direction = world_from_cam * in_camera.direction;
        let near_m = nearest_depth(self.view.projection).into();
        let world_ray = Ray { origin: eye + origin, direction };
        let mesh = self.mesh.and_then(|mesh| mesh.first(&world_ray, near_m));
        let disc = self.discs.first(&in_camera);
        let mesh_hit = mesh.map(|hit| MeshHit {
            depth_m: hit.depth_m,
            normal: hit.normal,
            uncertainty_m: hit.uncertainty_m,
        });
        let disc_hit = disc.map(|hit| {
            let point = &self.points[hit.index];
            let toward = match self.view.projection {
                ViewProjection::Perspective => (eye - point.position).normalize_or_zero(),
                ViewProjection::Orthographic => -direction,
            };
            DiscHit {
                depth_m: hit.depth_m,
                point: point.position - eye,
                normal: point.disc_normal(toward),
                has_normal: point.has_normal(),
            }
        });
        let Some(shown) = hybrid::shown(origin, direction, mesh_hit, disc_hit) else {
            return self.nothing(direction);
        };
        let what = match (shown.is_point, mesh, disc) {
            (false, Some(hit), _) => {
                What::Mesh { uncertainty_m: hit.uncertainty_m, class: hit.class }
            }
            (_, _, hit) => {
                What::Point { colour: hit.and_then(|hit| self.points[hit.index].colour) }
            }
        };
        let position = origin + direction * shown.depth_m;
        let pixels_per_m = self.view.pixels_a_metre(shown.depth_m);
        let blend = self.rigs.blend(eye + position, &shown, pixels_per_m);
        let surface = match (shown.is_point, blend.is_some()) {
            (false, false) => Surface::MeshUncoloured,
            (false, true) => Surface::MeshColoured,
            (true, false) => Surface::PointUncoloured,
            (true, true) => Surface::PointColoured,
        };
        let (depth_m, normal) = (shown.depth_m, shown.normal);
        let rgb = colour::colour(&colour::Pixel { depth_m, normal, what, blend }, self.mode);
        let place = Some(Place { position, depth_m, normal });
        Pixel { rgb, surface, place, ray: direction }
    }

    fn nothing(&self, ray: DVec3) -> Pixel {
        Pixel { rgb: self.background, surface: Surface::Background, place: None, ray }
    }

    /// What a raw pixel position sees, camera frame. What lies more than 80° off the axis of a
    /// distorted view is not drawn.
    fn ray(&self, pixel: DVec2) -> Option<Ray> {
        let lens = &self.view.camera.lens;
        let direction = lens.unproject(pixel)?;
        let off_axis = direction.truncate().abs().max_element();
        let drawn = lens.distortion == Distortion::None || off_axis <= MAX_TANGENT;
        drawn.then_some(match self.view.projection {
            ViewProjection::Perspective => Ray { origin: DVec3::ZERO, direction },
            ViewProjection::Orthographic => {
                Ray { origin: direction.with_z(0.0), direction: DVec3::Z }
            }
        })
    }
}

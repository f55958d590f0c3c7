//! A photograph: what it says about a place, and what hides the place from it.

use std::cell::RefCell;

use flaneur_scene::{ImageUpdate, Lens, PosedCamera};
use glam::{DVec2, DVec3};

use super::Ray;
use super::discs::{Discs, Point, Target};
use super::pyramid::Pyramid;
use super::triangles::Triangles;
use crate::camera::NEAR_M;
use crate::depth_map::reference::{CORNERS, Occluders, depth_bias, visible_share};
use crate::frustum::Frustum;
use crate::gains::reference::{FOOTPRINT, LEAST_TEXELS, agreement, continuity, known_surface};
use crate::mesh::reference::NO_MESH_M;
use crate::pinhole::{MAX_TANGENT, Pinhole};
use crate::shade::reference::{NEAREST_DEPTH_M, pixels_off};
use crate::surface::reference::Shown;

/// Fewer texels a pixel than these are rounding: the full level alone is exact.
const LEAST_TEXELS_PER_PIXEL: f64 = 1.015;

/// A photograph with its depth map.
#[derive(Debug)]
pub(super) struct Photograph<'a> {
    camera: PosedCamera,
    /// How far its place may be off, metres.
    pose_m: f64,
    /// The lens of the pixels that are there.
    lens: Lens,
    pyramid: Pyramid,
    map: Map<'a>,
}

/// Where a photograph sees a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Camera frame, metres.
    position: DVec3,
    /// Raw pixel.
    pixel: DVec2,
    /// Distance from the picture's border as a share of its shorter side.
    pub(super) border: f64,
}

/// A depth map, each texel made when it is first asked for.
#[derive(Debug)]
struct Map<'a> {
    pinhole: Pinhole,
    camera: PosedCamera,
    mesh: &'a Triangles,
    discs: Discs,
    texels: RefCell<Vec<Option<Occluders>>>,
}

impl<'a> Photograph<'a> {
    /// `None` for a lens that sees nothing.
    pub(super) fn new(
        image: &ImageUpdate,
        map_side: u32,
        mesh: &'a Triangles,
        points: &[Point],
    ) -> Option<Self> {
        let camera = image.camera;
        let pinhole = Pinhole::for_depth_map(&camera.lens, map_side)?;
        let discs = Discs::new(points, &camera, pinhole.focal.min_element(), Target::Map);
        let texels = RefCell::new(vec![None; pinhole.size.element_product() as usize]);
        Some(Self {
            camera,
            pose_m: image.uncertainty_m,
            lens: camera.lens.scaled_to(image.size),
            pyramid: Pyramid::new(image),
            map: Map { pinhole, camera, mesh, discs, texels },
        })
    }

    pub(super) fn centre(&self) -> DVec3 {
        self.camera.centre
    }

    /// Where the place at `position` (world) appears, if it does within the picture.
    pub(super) fn sees(&self, position: DVec3) -> Option<Seen> {
        let position = self.camera.cam_from_world(position);
        let tangent = position.truncate().abs().max_element() / position.z;
        if !(position.z >= NEAREST_DEPTH_M && tangent < MAX_TANGENT) {
            return None;
        }
        let pixel = self.lens.project(position)?;
        let size = self.lens.size.as_dvec2();
        let border = pixel.min(size - pixel).min_element() / size.min_element();
        (border > 0.0).then_some(Seen { position, pixel, border })
    }

    /// What it sees of a place, looked up where another one (world) appears.
    pub(super) fn displaced(&self, seen: &Seen, other: DVec3) -> Seen {
        let pixel = self.lens.project(self.camera.cam_from_world(other));
        Seen { pixel: pixel.unwrap_or(seen.pixel), ..*seen }
    }

    /// Share of the four texels of the depth map around the place that see it, by bilinear
    /// weight.
    pub(super) fn visible_share(&self, shown: &Shown, seen: &Seen) -> f64 {
        let map = &self.map.pinhole;
        let c = seen.position;
        let n = self.camera.cam_from_world * shown.normal;
        let first = (map.focal * (c.truncate() / c.z) + map.centre - 0.5).floor();
        let own_ray = (c.truncate() / c.z).extend(1.0);
        let bias = depth_bias(c.z / map.focal.min_element(), self.pose_m, n, own_ray);
        let known = CORNERS.map(|step| self.map.occluders(first + step));
        visible_share(map, c, n, bias, shown, &known)
    }

    /// Linear colour and mask where the place appears, for a picture that has `pixels_per_m` there and
    /// pixels `step` times as wide.
    pub(super) fn look_up(&self, seen: &Seen, pixels_per_m: f64, step: f64) -> (DVec3, f64) {
        self.pyramid.at(seen.pixel, self.texels_per_pixel(seen, pixels_per_m) * step)
    }

    /// The same of pixels as wide as that, but of a place that may be off by a `share` of its distance
    /// from an eye at `eye` (world).
    pub(super) fn look_up_unsure(
        &self,
        seen: &Seen,
        pixels_per_m: f64,
        eye: DVec3,
        share: f64,
    ) -> (DVec3, f64) {
        let from_eye = seen.position - self.camera.cam_from_world(eye);
        let off = pixels_off(share, from_eye, seen.position, self.lens.intrinsics.fy);
        self.pyramid.at(seen.pixel, self.texels_per_pixel(seen, pixels_per_m).max(off))
    }

    /// Linear colours to the four corners around a place, `reach` pixels of that picture aside, where
    /// those are `coarser` times as wide.
    pub(super) fn surroundings(
        &self,
        seen: &Seen,
        pixels_per_m: f64,
        step: f64,
        reach: f64,
        coarser: f64,
    ) -> [DVec3; 4] {
        let texels = self.texels_per_pixel(seen, pixels_per_m) * step;
        let (aside, coarse) = (reach * texels, coarser * texels);
        [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
            .map(|corner| self.pyramid.at(seen.pixel + aside * DVec2::from(corner), coarse).0)
    }

    /// How many of its texels are a pixel of a picture that has `pixels_per_m` there.
    fn texels_per_pixel(&self, seen: &Seen, pixels_per_m: f64) -> f64 {
        let texels_per_m = self.lens.intrinsics.fy / seen.position.z;
        let texels = texels_per_m / pixels_per_m;
        if texels < LEAST_TEXELS_PER_PIXEL { 1.0 } else { texels.min(self.pyramid.coarsest()) }
    }
}

impl Photograph<'_> {
    /// What it can see something of.
    pub(super) fn frustum(&self) -> Frustum {
        Frustum::new(&self.camera, &self.map.pinhole)
    }

    /// A place (world) that lies at this share of its depth map's sides, for comparing exposures,
    /// with the width of what is averaged there, metres; `None` at edges, and where nothing is.
    pub(super) fn lends(&self, share: DVec2) -> Option<(DVec3, f64)> {
        let Pinhole { focal, size, .. } = self.map.pinhole;
        let texel = (share * size.as_dvec2()).floor();
        let (z, _) = known_surface(self.map.occluders(texel))?;
        let reach = (0.5 * FOOTPRINT * focal.x).ceil();
        let goes_on = |side: &DVec2| {
            let beside = known_surface(self.map.occluders(texel + *side * reach));
            beside.is_some_and(|(beside_m, _)| continuity(z, beside_m) >= 0.0)
        };
        let whole = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].iter().all(goes_on);
        let direction = self.camera.cam_from_world.transpose() * self.map.ray(texel);
        whole.then(|| (self.camera.centre + direction * z, FOOTPRINT * z))
    }

    /// The mean linear colour that it shows `width_m` around a place (world), if it sees it.
    pub(super) fn shows(&self, position: DVec3, width_m: f64) -> Option<DVec3> {
        let seen = self.sees(position)?;
        let z = seen.position.z;
        let Pinhole { focal, centre, .. } = self.map.pinhole;
        let texel = (focal * (seen.position.truncate() / z) + centre).floor();
        let known = known_surface(self.map.occluders(texel))?;
        let texels = width_m * self.lens.intrinsics.fy / z;
        let width = texels.clamp(1.0, self.pyramid.coarsest());
        let border_px = seen.border * self.lens.size.as_dvec2().min_element();
        if texels < LEAST_TEXELS || border_px < width || agreement(z, known) < 0.0 {
            return None;
        }
        let (colour, inside) = self.pyramid.at(seen.pixel, width);
        (inside > 0.0).then_some(colour)
    }
}

impl Map<'_> {
    /// Direction, camera frame, depth 1, of a texel's centre.
    fn ray(&self, texel: DVec2) -> DVec3 {
        ((texel + 0.5 - self.pinhole.centre) / self.pinhole.focal).extend(1.0)
    }

    /// What a texel knows; beyond the map's border what the nearest texel does.
    fn occluders(&self, texel: DVec2) -> Occluders {
        let size = self.pinhole.size.as_dvec2();
        let texel = texel.max(DVec2::ZERO).min(size - 1.0);
        let index = (texel.y * size.x + texel.x) as usize;
        if let Some(known) = self.texels.borrow()[index] {
            return known;
        }
        let direction = self.ray(texel);
        let disc = self.discs.first(&Ray { origin: DVec3::ZERO, direction });
        let direction = self.camera.cam_from_world.transpose() * direction;
        let mesh = self.mesh.first(&Ray { origin: self.camera.centre, direction }, NEAR_M.into());
        let found = Occluders {
            mesh_m: mesh.map_or(NO_MESH_M, |hit| hit.depth_m),
            mesh_uncertainty_m: mesh.map_or(0.0, |hit| hit.uncertainty_m),
            point_m: disc.map_or(f64::INFINITY, |hit| hit.depth_m),
        };
        self.texels.borrow_mut()[index] = Some(found);
        found
    }
}

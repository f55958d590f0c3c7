//! What a pixel of a picture shows, for those who measure.
//!
//! The place is that of the frame's own record, moved on its plane to where the pixel's ray meets it.
//! Which photographs see it is decided as it is for colours, by their depth maps and masks; but in f64,
//! and for all photographs in whose pictures it lies, not only those of the nearest rigs.

use std::collections::BTreeMap;

use flaneur_scene::{ImageId, SurfaceClass, View};
use glam::{DVec2, DVec3, UVec2};

use crate::depth_map::reference::POINT_NOISE_M;
use crate::depth_map::reference::{CORNERS, Occluders, depth_bias, visible_share};
use crate::depths::{KIND_BITS, SHOWS_MESH, SHOWS_POINT};
use crate::octahedral;
use crate::photographs::Photograph;
use crate::pinhole::MAX_TANGENT;
use crate::shade::photograph::{Standing, closeness};
use crate::shade::reference::{
    NEAREST_DEPTH_M, edge_weight, feather_weight, mask_weight, park_weight,
};
use crate::surface::reference::{RELIEF_M, Shown};

mod texels;

pub(crate) use texels::{Texel, Texels, Words};

/// The flag of a record whose place may have points of its surface before it; `HAS_RELIEF` in
/// surface/place.wgsl.
pub(crate) const HAS_RELIEF: u32 = 8;
/// Most photographs that are asked whether they see a place.
pub(crate) const MOST_ASKED: usize = 48;
/// From this share of the footprint on a photograph sees it.
const SEES: f64 = 0.5;
/// A ray is not followed to its place's plane farther than this, pixels: planes seen edge-on.
const MOST_MOVED_PX: f64 = 2.0;

/// A surveyed place.
#[derive(Clone, Debug, PartialEq)]
pub struct Picked {
    /// World, metres.
    pub position: DVec3,
    /// Unit, towards the eye, world.
    pub normal: DVec3,
    /// How far the surface may be from there, metres.
    pub uncertainty_m: f64,
    /// What was surveyed.
    pub surface: PickedSurface,
    /// The photographs that see it, the one that counts most first.
    pub seen_by: Vec<Sight>,
}

/// What a surveyed place is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PickedSurface {
    /// A surface of the mesh.
    Mesh(SurfaceClass),
    /// A point.
    Point,
}

/// A photograph that sees a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// Which.
    pub id: ImageId,
    /// Where in it, pixels of level 0.
    pub pixel: DVec2,
    /// From its camera, metres.
    pub distance_m: f64,
    /// Its part in the colour that the picture has there, 0 to 1.
    pub share: f64,
}

/// A place as the surface pass left it in a pixel's record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recorded {
    /// World, metres: where the pixel's own ray meets it.
    pub(crate) position: DVec3,
    pub(crate) shown: Shown,
    pub(crate) surface: PickedSurface,
    pub(crate) uncertainty_m: f64,
}

/// A photograph in whose picture a place lies.
#[derive(Debug)]
pub(crate) struct Asked<'a> {
    pub(crate) id: &'a ImageId,
    pub(crate) photograph: &'a Photograph,
    pub(crate) standing: Option<Standing>,
    /// Of the place, camera frame.
    position: DVec3,
    /// Of the level that is resident.
    pub(crate) pixel: DVec2,
    /// Distance from the picture's border as a share of its shorter side.
    border: f64,
}

impl Recorded {
    /// What the record of `pixel` says; `None` where that is nothing surveyed. `orientation` is what
    /// surface/place.wgsl packs beside `position`.
    pub(crate) fn new(
        view: &View,
        pixel: DVec2,
        position: [u32; 4],
        orientation: [u32; 2],
    ) -> Option<Self> {
        let ([x, y, z, flags], [normal, code]) = (position, orientation);
        let kind = flags & KIND_BITS;
        if !matches!(kind, SHOWS_MESH | SHOWS_POINT) {
            return None;
        }
        let is_point = kind == SHOWS_POINT;
        let stated_m = f64::from(half::f16::from_bits((flags >> 16) as u16));
        let relief_m = if flags & HAS_RELIEF != 0 { stated_m.max(RELIEF_M) } else { 0.0 };
        let relative = DVec3::from_array([x, y, z].map(|word| f64::from(f32::from_bits(word))));
        let normal = octahedral::vector(normal).as_dvec3();
        let depth_m = relative.dot(view.camera.forward());
        Some(Self {
            position: met(view, pixel, view.eye() + relative, normal),
            shown: Shown { is_point, depth_m, normal, relief_m },
            surface: if is_point { PickedSurface::Point } else { class_of(code) },
            uncertainty_m: if is_point { POINT_NOISE_M } else { stated_m },
        })
    }
}

impl<'a> Asked<'a> {
    /// `None` where the place (world) is not in the picture.
    pub(crate) fn new(
        id: &'a ImageId,
        photograph: &'a Photograph,
        standing: Option<Standing>,
        place: DVec3,
    ) -> Option<Self> {
        let position = photograph.camera.cam_from_world(place);
        let tangent = position.truncate().abs().max_element() / position.z;
        if !(position.z >= NEAREST_DEPTH_M && tangent < MAX_TANGENT) {
            return None;
        }
        let lens = photograph.resident_lens();
        let pixel = lens.project(position)?;
        let size = lens.size.as_dvec2();
        let border = pixel.min(size - pixel).min_element() / size.min_element();
        (border > 0.0).then_some(Self { id, photograph, standing, position, pixel, border })
    }

    /// Where the place lies in the depth map, texels, less half a texel.
    fn on_map(&self) -> DVec2 {
        let map = &self.photograph.map;
        map.focal * (self.position.truncate() / self.position.z) + map.centre - 0.5
    }

    /// From the camera, metres.
    pub(crate) fn distance_m(&self) -> f64 {
        self.position.length()
    }

    /// The four texels of the depth map around the place.
    pub(crate) fn map_texels(&self) -> [UVec2; 4] {
        let last = self.photograph.map.size.as_dvec2() - 1.0;
        CORNERS.map(|step| (self.on_map().floor() + step).clamp(DVec2::ZERO, last).as_uvec2())
    }

    /// How it sees the place of which the four texels know so much, and a texel of its mask shows
    /// `inside`.
    pub(crate) fn weighed(
        &self,
        eye: DVec3,
        recorded: &Recorded,
        known: [Occluders; 4],
        inside: f64,
    ) -> Weighed {
        let visible = self.visible(&recorded.shown, known);
        let sight = Sight {
            id: self.id.clone(),
            pixel: self.original_pixel(),
            distance_m: self.distance_m(),
            share: 0.0,
        };
        let sees = visible >= SEES && inside > 0.0;
        let visible = if sees { visible } else { 0.0 };
        Weighed { sight: sees.then_some(sight), say: self.say(eye, recorded, visible, inside) }
    }

    /// Share of them that see it.
    fn visible(&self, shown: &Shown, known: [Occluders; 4]) -> f64 {
        let map = &self.photograph.map;
        let n = self.photograph.camera.cam_from_world * shown.normal;
        let own_ray = (self.position.truncate() / self.position.z).extend(1.0);
        let texel_m = self.position.z / map.focal.min_element();
        let pose_m = f64::from(self.photograph.uncertainty_m);
        let bias = depth_bias(texel_m, pose_m, n, own_ray);
        visible_share(map, self.position, n, bias, shown, &known)
    }

    /// The same pixel of level 0.
    fn original_pixel(&self) -> DVec2 {
        let (level, original) = (self.photograph.resident_lens(), self.photograph.camera.lens);
        self.pixel * original.size.as_dvec2() / level.size.as_dvec2()
    }

    /// Its say among the rigs that colour the picture; `None` where its own is none of them.
    fn say(&self, eye: DVec3, recorded: &Recorded, visible: f64, inside: f64) -> Option<Say> {
        let Standing { rig, nearest_2, weight, .. } = self.standing?;
        let centre = self.photograph.camera.centre;
        let score = self.border * closeness(centre.distance_squared(eye), nearest_2);
        let weight = park_weight(recorded.shown.normal, recorded.position, centre, nearest_2)
            * feather_weight(score)
            * mask_weight(inside)
            * edge_weight(visible)
            * weight;
        Some(Say { rig, score, weight })
    }
}

/// A photograph in whose picture a place lies, and what it says of its colour.
#[derive(Debug)]
pub(crate) struct Weighed {
    /// Where it sees it, if so.
    sight: Option<Sight>,
    say: Option<Say>,
}

/// What a photograph has to say: its rig, how well it stands in it, and its weight if it speaks for it.
#[derive(Clone, Copy, Debug)]
struct Say {
    rig: usize,
    score: f64,
    weight: f64,
}

/// Those that see a place, each with its share, that which counts most first. As in the picture, one
/// camera speaks for each rig, and for nothing where something hides the place from it.
pub(crate) fn shared_out(weighed: Vec<Weighed>) -> Vec<Sight> {
    let mut best: BTreeMap<usize, (usize, Say)> = BTreeMap::new();
    for (index, weighed) in weighed.iter().enumerate() {
        let Some(say) = weighed.say else { continue };
        if best.get(&say.rig).is_none_or(|(_, other)| say.score > other.score) {
            best.insert(say.rig, (index, say));
        }
    }
    let sum: f64 = best.values().map(|(_, say)| say.weight).sum();
    let mut sights: Vec<Option<Sight>> = weighed.into_iter().map(|weighed| weighed.sight).collect();
    for (index, say) in best.into_values() {
        if let Some(Some(sight)) = sights.get_mut(index).filter(|_| sum > 0.0) {
            sight.share = say.weight / sum;
        }
    }
    let mut sights: Vec<Sight> = sights.into_iter().flatten().collect();
    sights.sort_by(|a, b| {
        let nearer = a.distance_m.total_cmp(&b.distance_m);
        b.share.total_cmp(&a.share).then(nearer)
    });
    sights
}

/// Where the ray of `pixel` meets the plane of a place and its normal (world), the place itself where
/// that is far aside.
fn met(view: &View, pixel: DVec2, place: DVec3, normal: DVec3) -> DVec3 {
    let Some(ray) = view.ray(pixel) else { return place };
    let depth_m = normal.dot(place - ray.origin) / normal.dot(ray.direction);
    let met = ray.origin + ray.direction * depth_m;
    let most_m = MOST_MOVED_PX / view.pixels_a_metre(depth_m);
    // Written so that what is no number is far aside.
    if depth_m > 0.0 && met.distance(place) <= most_m { met } else { place }
}

fn class_of(code: u32) -> PickedSurface {
    PickedSurface::Mesh(match code {
        0 => SurfaceClass::Ground,
        1 => SurfaceClass::Wall,
        _ => SurfaceClass::Roof,
    })
}

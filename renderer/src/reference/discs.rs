//! The points as discs, as one camera sees them, asked ray by ray.

use std::collections::BTreeMap;
use std::sync::Arc;

use flaneur_scene::{Bounds3, PointChunk, PointNodeId, PosedCamera, ViewProjection};
use glam::{DVec3, Vec3};

use super::Ray;
use super::boxes::Boxes;
use super::taken::Taken;
use crate::camera::{NEAR_M, nearest_depth};
use crate::points::{BLOCK_POINTS, surveyed};
use crate::settings::SplatNormals;
use crate::splat::reference::{
    self, depth_along, disc_normal, drawn_radius, drawn_radius_without_perspective,
};
use crate::{Settings, splat};

/// No map knows of points beyond, so that ranks are so far apart, metres.
const FARTHEST_M: f64 = 16_384.0;

/// A point of the scene, whoever looks at it.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// World frame.
    pub(super) position: DVec3,
    /// sRGB, where it has one.
    pub(super) colour: Option<[u8; 3]>,
    /// Unit; zero where it has none.
    normal: DVec3,
    /// On views: that of its node, or of finer nodes around it.
    radius_m: f64,
    /// On depth maps: that of its own node.
    map_radius_m: f64,
    /// Whence it was taken, where that is known and wanted.
    taken: Option<Arc<Taken>>,
}

impl Point {
    pub(super) fn has_normal(&self) -> bool {
        self.normal != DVec3::ZERO
    }

    /// The normal of its disc for an eye in the direction `toward`: unit, towards it.
    pub(super) fn disc_normal(&self, toward: DVec3) -> DVec3 {
        disc_normal(toward, self.normal).normalize_or_zero()
    }
}

/// Discs as a camera sees them, in its frame.
#[derive(Debug)]
pub(super) struct Discs {
    discs: Vec<Disc>,
    boxes: Boxes,
}

#[derive(Clone, Copy, Debug)]
struct Disc {
    point: reference::Point,
    /// Unit: how the eye looks at it.
    toward: DVec3,
    /// Depths are pushed back by this, metres.
    push_m: f64,
    /// So much more does another disc go first, metres.
    behind_m: f64,
    /// Which point.
    index: usize,
}

/// Where a ray meets the nearest disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Along the axis, pushed back.
    pub(super) depth_m: f64,
    /// Which point.
    pub(super) index: usize,
}

/// How a camera draws discs.
#[derive(Clone, Copy, Debug)]
pub(super) enum Target {
    /// A view.
    View(ViewProjection),
    /// A photograph's depth map.
    Map,
}

/// All points of a scene that can be drawn, in the order of their nodes.
pub(super) fn points(
    chunks: &BTreeMap<PointNodeId, Arc<PointChunk>>,
    settings: &Settings,
) -> Vec<Point> {
    let most_m = f64::from(settings.max_splat_radius_m);
    let radius = |spacing_m: f32| {
        let spacing_m = f64::from(spacing_m);
        let radius_m = (spacing_m * f64::from(settings.splat_scale)).min(most_m);
        // Discs that cannot touch their neighbours close nothing.
        if spacing_m > 2.0 * most_m {
            radius_m * (2.0 * most_m / spacing_m).powi(2)
        } else {
            radius_m
        }
    };
    let own_radius = |chunk: &PointChunk| radius(chunk.spacing_m);
    let positions = |chunk: &PointChunk| -> Vec<(usize, DVec3)> {
        let near = |p: &[f32; 3]| p.iter().all(|x| x.abs() <= 1e6);
        let world = |p: &[f32; 3]| chunk.origin + Vec3::from_array(*p).as_dvec3();
        let kept = chunk.positions.iter().enumerate().filter(|(_, p)| near(p));
        kept.map(|(i, p)| (i, world(p))).collect()
    };
    let extents: Vec<(PointNodeId, Bounds3, f64)> = chunks
        .iter()
        .map(|(id, chunk)| {
            let mut bounds = Bounds3::EMPTY;
            positions(chunk).into_iter().for_each(|(_, p)| bounds.include(p));
            (*id, bounds, coded(own_radius(chunk)))
        })
        .collect();
    let estimated = settings.splat_normals == SplatNormals::Estimated;
    let mut points = Vec::new();
    for (id, chunk) in chunks {
        let own_radius_m = own_radius(chunk);
        let below: Vec<&(PointNodeId, Bounds3, f64)> =
            extents.iter().filter(|(other, ..)| is_below(other, id)).collect();
        let positions = positions(chunk);
        let taken =
            if settings.near_first { Taken::of_blocks(chunk, &positions) } else { Vec::new() };
        for (number, (i, position)) in positions.into_iter().enumerate() {
            let around = below.iter().filter(|(_, bounds, _)| bounds.distance(position) == 0.0);
            let of_point = chunk.spacings_m.get(i).map(|&spacing_m| coded(radius(spacing_m)));
            let radius_m = around
                .map(|(.., radius)| *radius)
                .chain(of_point)
                .fold(coded(own_radius_m), f64::min);
            let colour = surveyed::colour(chunk, i);
            let normal =
                chunk.normals.get(i).map_or(DVec3::ZERO, |n| Vec3::from_array(*n).as_dvec3());
            let normal = if estimated { normal } else { DVec3::ZERO };
            let map_radius_m = own_radius_m.min(f64::from(splat::MAX_MAP_RADIUS_M));
            let taken = taken.get(number / BLOCK_POINTS).cloned().flatten();
            points.push(Point { position, colour, normal, radius_m, map_radius_m, taken });
        }
    }
    points
}

/// The stored radius nearest to `radius_m`: eight steps an octave from 1 mm, 127 of them.
fn coded(radius_m: f64) -> f64 {
    0.001 * ((8.0 * (radius_m / 0.001).log2()).round().clamp(1.0, 127.0) / 8.0).exp2()
}

fn is_below(other: &PointNodeId, id: &PointNodeId) -> bool {
    let mut above = other.key.parent();
    while let Some(key) = above {
        if key == id.key {
            return other.source == id.source;
        }
        above = key.parent();
    }
    false
}

impl Discs {
    /// The discs of `points` for a camera whose ideal pixels have the focal length `focal_px`,
    /// the smaller of its two.
    pub(super) fn new(
        points: &[Point],
        camera: &PosedCamera,
        focal_px: f64,
        target: Target,
    ) -> Self {
        let near_m = match target {
            Target::View(projection) => nearest_depth(projection).into(),
            Target::Map => NEAR_M.into(),
        };
        let disc = |(index, seen): (usize, &Point)| {
            let position = camera.cam_from_world(seen.position);
            let normal = camera.cam_from_world * seen.normal;
            let (stored_m, largest_px, push) = match (target, seen.has_normal()) {
                (Target::View(_), _) => (seen.radius_m, splat::MAX_RADIUS_PX, 0.0),
                (Target::Map, false) => {
                    (seen.map_radius_m, splat::MAX_MAP_RADIUS_PX, splat::MAP_PUSH)
                }
                (Target::Map, true) => {
                    (seen.map_radius_m, splat::MAX_MAP_RADIUS_PX, splat::MAP_PUSH_ON_PLANE)
                }
            };
            let parallel = matches!(target, Target::View(ViewProjection::Orthographic));
            let (toward, radius_m) = if parallel {
                let radius_m = drawn_radius_without_perspective(stored_m, focal_px, largest_px);
                (DVec3::Z, radius_m)
            } else {
                let radius_m = drawn_radius(stored_m, position, focal_px, largest_px);
                (position.normalize_or_zero(), radius_m)
            };
            let push_m = f64::from(push) * radius_m;
            let behind_m = match (target, &seen.taken) {
                (_, None) => 0.0,
                (Target::View(_), Some(taken)) => taken.behind_in_view_m(camera.centre),
                (Target::Map, Some(taken)) => {
                    FARTHEST_M * f64::from(taken.rank_in_map(camera.centre)?)
                }
            };
            let point = reference::Point { position, normal, radius_m };
            (position.z >= near_m).then_some(Disc { point, toward, push_m, behind_m, index })
        };
        let discs: Vec<Disc> = points.iter().enumerate().filter_map(disc).collect();
        let around = |Disc { point, .. }: &Disc| Bounds3 {
            min: point.position - point.radius_m,
            max: point.position + point.radius_m,
        };
        let bounds: Vec<Bounds3> = discs.iter().map(around).collect();
        Self { discs, boxes: Boxes::new(&bounds) }
    }

    /// The first disc on a ray in the camera's frame: lowest depth and what is behind others,
    /// then lowest index.
    pub(super) fn first(&self, ray: &Ray) -> Option<Hit> {
        let found = self.boxes.first(ray, |item| {
            let Disc { point, toward, push_m, behind_m, .. } = &self.discs[item];
            let depth_m = depth_along(point, *toward, ray.origin, ray.direction)? + push_m;
            Some((depth_m + behind_m, depth_m))
        })?;
        Some(Hit { depth_m: found.hit, index: self.discs[found.item].index })
    }
}

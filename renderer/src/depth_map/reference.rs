//! The depth test, in f64.
//!
//! A depth map knows two surfaces a texel: the nearest mesh, uncertain by δ, and the nearest
//! point, certain to centimetres. A place is tested against each according to what it is:
//!
//! | the place is | against mesh at `z_m ± δ_m` | against a point at `z_p` |
//! |---|---|---|
//! | mesh | exactly: both come from the same mesh | the point may be the same surface: `z − ρ ≤ z_p` |
//! | a point | the mesh occludes from its far surface: `z ≤ z_m + δ_m` | `z − ρ ≤ z_p` |
//!
//! Both comparisons leave a bias β. It holds the width w of one texel: where two faces meet, the
//! texel's centre may lie on the other one. The slope of the place's own plane needs no allowance
//! for the texel, because its depth is taken on the ray of the texel's centre, where the map was
//! drawn. But a camera whose place is uncertain by σ metres may see that plane elsewhere: moved
//! along its axis by σ, and aside by σ, which changes the depth of a plane of normal n by
//! σ |n_xy| / |n · ray|. So β = w + σ (1 + |n_xy| / |n · ray|).
//!
//! β is derived, from what a map and a pose are said to be good for. Apart from it stand physical
//! allowances, which no equation gives: what scanners, drives and discs do to one surface. They are
//! constants, each with its reason: `POINT_NOISE_M`, `UNDECIDED_M` and `LEAST_SLOPE` here, `RELIEF_M`
//! and `SAME_SURFACE_M` in surface/reference.rs.
//!
//! ρ is the relief of the surface: points that stand out of the plane n · (P − C) = 0 by no
//! more than `relief_m` are that surface, which is `relief_m / |n · ray|` in depth. It covers the
//! mesh's uncertainty δ, and the discs of the maps, which face the photograph and so stand out
//! of an inclined surface by up to their radius. A road seen from a car is inclined by 80° and
//! more: without ρ it hides itself. Points whose orientation is not known have none.
//!
//! Drives put the same surface up to decimetres apart, and then its points hide each other. So
//! what points hide by less than 40 cm is undecided rather than hidden: it keeps a ten-thousandth
//! of its visibility, less and less towards 40 cm. Beside a photograph that sees the place this
//! counts for nothing; where none does, the place is not left without colour.

use glam::{DVec2, DVec3};

use crate::pinhole::Pinhole;
use crate::surface::reference::Shown;

/// What one texel knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Occluders {
    pub(crate) mesh_m: f64,
    pub(crate) mesh_uncertainty_m: f64,
    pub(crate) point_m: f64,
}

/// What is being tested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    Mesh,
    Point,
}

/// Physical allowance beside β: the noise of lidar ranges, metres. Scanners of surveys are
/// good to 5 mm to 3 cm, by make and by what they meet. β knows of poses and texels only.
pub(crate) const POINT_NOISE_M: f64 = 0.03;

/// Physical allowance beside β: how far apart drives may put one surface, metres. Where houses hide the
/// sky, positions drift by some decimetres between two drives; what stands farther before a place than
/// that is another thing, a car or a pole, and hides it.
pub(crate) const UNDECIDED_M: f64 = 0.4;

/// What is left of visibility where they have: no photograph that sees a place clearly is outweighed by
/// one that may not.
pub(crate) const UNDECIDED: f64 = 1e-4;

/// Sine of the angle between ray and plane below which neither relief nor bias grows further: 6°. Both
/// grow as one over the sine, without end, and a road far ahead would be seen through the cars on it.
/// It bounds β rather than being a part of it: normals of points are no better than some degrees.
pub(crate) const LEAST_SLOPE: f64 = 0.1;

pub(crate) fn depth_on_texel_ray(c: DVec3, n: DVec3, ray: DVec3) -> f64 {
    let z = n.dot(c) / n.dot(ray);
    if z > 0.0 { z.min(c.z).max(0.5 * c.z) } else { c.z }
}

pub(crate) fn relief_depth(relief_m: f64, n: DVec3, ray: DVec3) -> f64 {
    relief_m / n.dot(ray).abs().max(LEAST_SLOPE)
}

pub(crate) fn depth_bias(texel_m: f64, pose_m: f64, n: DVec3, ray: DVec3) -> f64 {
    texel_m + pose_m * (1.0 + n.truncate().length() / n.dot(ray).abs().max(LEAST_SLOPE))
}

pub(crate) fn visibility(
    z: f64,
    bias: f64,
    place: Place,
    relief: f64,
    occluders: Occluders,
) -> f64 {
    let before_mesh = match place {
        Place::Mesh => z,
        Place::Point => z - occluders.mesh_uncertainty_m,
    };
    if before_mesh > occluders.mesh_m + bias {
        return 0.0;
    }
    let hidden_by_m = z - relief - bias - POINT_NOISE_M - occluders.point_m;
    if hidden_by_m <= 0.0 { 1.0 } else { UNDECIDED * (1.0 - hidden_by_m / UNDECIDED_M).max(0.0) }
}

/// From the first of four texels to each of them.
pub(crate) const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];

/// Share of the four texels of a map around the place `c` (camera frame) that see it, by bilinear
/// weight. `n`: its normal, camera frame; `bias`: see [`depth_bias`]; `known`: what the texels know, in
/// the order of [`CORNERS`].
pub(crate) fn visible_share(
    map: &Pinhole,
    c: DVec3,
    n: DVec3,
    bias: f64,
    shown: &Shown,
    known: &[Occluders; 4],
) -> f64 {
    let at = map.focal * (c.truncate() / c.z) + map.centre - 0.5;
    let (first, t) = (at.floor(), at - at.floor());
    let place = if shown.is_point { Place::Point } else { Place::Mesh };
    CORNERS
        .into_iter()
        .zip(known)
        .map(|(step, &occluders)| {
            let ray = ((first + step + 0.5 - map.centre) / map.focal).extend(1.0);
            let z = depth_on_texel_ray(c, n, ray);
            let relief = relief_depth(shown.relief_m, n, ray);
            let share = DVec2::ONE - step + (2.0 * step - 1.0) * t;
            share.x * share.y * visibility(z, bias, place, relief, occluders)
        })
        .sum()
}

/// Metres between the ranks of what a map of points holds, see points/remote.rs.
const RANK_M: f64 = 16_384.0;

/// Depth of the point that a map's texel holds, metres; infinite where there is none.
pub(crate) fn nearest_point_m(held: f32) -> f64 {
    if held.is_nan() { f64::INFINITY } else { f64::from(held).rem_euclid(RANK_M) }
}

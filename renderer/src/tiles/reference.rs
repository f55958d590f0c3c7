//! Which photographs are to be asked about a tile, in f64.
//!
//! A photograph sees a place that its lens projects into its picture, no nearer to the plane of its
//! eye and no further off its axis than where photographs are looked up. All that it sees lies in a
//! pyramid: before the plane of its eye, and within four planes through its centre.
//!
//! The places of a tile lie in a box. Along the world's axes, or the camera's, it would hold much that
//! the tile does not show: a road runs from the lower end of a tile to its upper one aside as it runs ahead. So it
//! is one in q = (x, y, 1) / z, where z is the depth before the picture's camera: there a tile is a box
//! itself, and planes stay planes, since n . p + d >= 0 is n . (q_x, q_y, 1) + d q_z >= 0. Where
//! rays are parallel a tile is a box in (x, y, z).
//!
//! Box and pyramid do not meet where one plane of the pyramid has all corners of the box on its outer side. Where
//! none has, they may yet miss each other: the photograph is then asked in vain. It is never left
//! out wrongly.

use flaneur_scene::{PosedCamera, View, ViewProjection};
use glam::{BVec3, DVec2, DVec3};

use crate::frustum::Frustum;
use crate::pinhole::MAX_TANGENT;
use crate::shade::reference::NEAREST_DEPTH_M;

/// Whether a photograph sees a place (world).
pub(crate) fn sees(photograph: &PosedCamera, place: DVec3) -> bool {
    let position = photograph.cam_from_world(place);
    let tangents = position.truncate() / position.z;
    let looked_up = position.z >= NEAREST_DEPTH_M && tangents.abs().max_element() < MAX_TANGENT;
    let pixel = photograph.lens.project(position).filter(|_| looked_up);
    pixel.is_some_and(|pixel| {
        pixel.cmpgt(DVec2::ZERO).all() && pixel.cmplt(photograph.lens.size.as_dvec2()).all()
    })
}

/// How far the box around `places` (world), which `view` shows in one tile, reaches into the pyramid: in
/// metres at the depth 1, or anywhere where rays are parallel. Negative where it cannot meet it, by how
/// far it is outside.
pub(crate) fn reach(pyramid: &Frustum, places: &[DVec3], view: &View) -> f64 {
    let of = |place: &DVec3| {
        let p = view.camera.cam_from_world(*place);
        match view.projection {
            ViewProjection::Perspective => DVec3::new(p.x, p.y, 1.0) / p.z,
            ViewProjection::Orthographic => p,
        }
    };
    let low = places.iter().map(of).fold(DVec3::INFINITY, DVec3::min);
    let high = places.iter().map(of).fold(DVec3::NEG_INFINITY, DVec3::max);
    let corner = |i: u32| DVec3::select(BVec3::new(i & 1 == 1, i & 2 == 2, i & 4 == 4), high, low);
    let innermost = |(n, on): (DVec3, DVec3)| {
        let n = view.camera.cam_from_world * n;
        let d = -n.dot(view.camera.cam_from_world(on));
        let inside = |q: DVec3| match view.projection {
            ViewProjection::Perspective => n.dot(q.truncate().extend(1.0)) + d * q.z,
            ViewProjection::Orthographic => n.dot(q) + d,
        };
        (0..8).map(corner).map(inside).fold(f64::NEG_INFINITY, f64::max)
    };
    pyramid.planes().map(innermost).into_iter().fold(f64::INFINITY, f64::min)
}

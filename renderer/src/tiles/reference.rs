//! Which photographs are to be asked about a tile, in f64.
//!
//! A photograph sees a place that its lens projects into its picture, no nearer to the plane of its
//! eye and no further off its axis than where photographs are looked up. All that it sees lies in a
//! pyramid: before the plane of its eye, and within four planes through its centre.
//!
//! The places of a tile lie in a box along the axes. Box and pyramid do not meet where one plane of
//! the pyramid has all corners of the box on its outer side. Where none has, they may yet miss each
//! other: the photograph is then asked in vain. It is never left out wrongly.

use flaneur_scene::PosedCamera;
use glam::{DVec2, DVec3};

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

/// How far the box around `places` (world) reaches into the pyramid, metres: negative where it
/// cannot meet it, by how far it is outside.
pub(crate) fn reach(pyramid: &Frustum, places: &[DVec3]) -> f64 {
    let corners: Vec<DVec3> = (0..8)
        .map(|corner| {
            DVec3::from_array([0, 1, 2].map(|axis| {
                let along = places.iter().map(|place| place[axis]);
                match corner >> axis & 1 {
                    0 => along.fold(f64::INFINITY, f64::min),
                    _ => along.fold(f64::NEG_INFINITY, f64::max),
                }
            }))
        })
        .collect();
    let innermost = |(n, on): (DVec3, DVec3)| {
        corners.iter().map(|corner| n.dot(corner - on)).fold(f64::NEG_INFINITY, f64::max)
    };
    pyramid.planes().map(innermost).into_iter().fold(f64::INFINITY, f64::min)
}

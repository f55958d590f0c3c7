//! The weights of blending, in f64.
//!
//! Park et al., equation 4: `w = max(0, n · v)^α / (dist_ik² dist_uk²)` with α = 4, where n is
//! the normal of the place i, v the unit vector from it to photograph k, `dist_ik` their
//! distance and `dist_uk` that from the eye to the nearest camera of the photograph's rig. Both
//! squares are grown by (5 cm)², which keeps the weight finite and smooth where the eye reaches a
//! photograph's centre: there it outweighs one 3 m away 3600 times.
//!
//! Below a cosine of 0.01, or 0.6°, a photograph has no say: a place on the plane through its
//! centre would otherwise be coloured, or not, by rounding alone.
//!
//! To that come factors between 0 and 1 that take a photograph's say away smoothly before its
//! border, before the edge of its mask, and before the edge of what hides the place from it.
//!
//! A rig speaks through the camera of largest score `border × closeness`. As the eye moves, another
//! camera takes over where the two scores are equal. The rig's say does not jump there, because
//! its distance from the eye is one for all its cameras, and because what counts as near the border
//! is decided by the score.

use glam::DVec3;

/// Nothing nearer to a photograph's eye plane is looked up in it, metres.
pub(crate) const NEAREST_DEPTH_M: f64 = 0.05;
/// Masks this close to one have nothing hidden in them.
pub(crate) const OPAQUE: f64 = 0.999;
/// Keeps the weight finite where the eye, or the place, is at a photograph's centre, metres.
pub(crate) const NEAREST_M: f64 = 0.05;
/// Cosine at which a surface is seen so nearly edge-on that nothing is seen of it.
pub(crate) const SEEN_COSINE: f64 = 0.01;
/// Share of the picture's shorter side over which a photograph fades towards its border.
pub(crate) const FEATHER: f64 = 0.05;

/// `eye_distance_2`: the square of `dist_uk`, metres.
pub(crate) fn park_weight(n: DVec3, place: DVec3, photograph: DVec3, eye_distance_2: f64) -> f64 {
    let to_photograph = photograph - place;
    let cosine = n.dot(to_photograph.normalize());
    if cosine <= SEEN_COSINE {
        return 0.0;
    }
    cosine.powi(4)
        / ((to_photograph.length_squared() + NEAREST_M.powi(2))
            * (eye_distance_2 + NEAREST_M.powi(2)))
}

pub(crate) fn feather_weight(border: f64) -> f64 {
    let t = (border / FEATHER).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// `inside` rises from 0 at the mask's edge to 1, see [`flaneur_scene::ImageUpdate::rgba`]. The
/// weights of two photographs differ by factors of hundreds where the eye is close to one of them;
/// the third power spreads the change from one to the other over a fair part of the feather all
/// the same.
pub(crate) fn mask_weight(inside: f64) -> f64 {
    (inside * inside * (3.0 - 2.0 * inside)).powi(3)
}

/// Up to half of the footprint the photograph has next to no say: enough where no other sees
/// the place, so that the line where two walls meet is not left without colour.
pub(crate) fn edge_weight(visible: f64) -> f64 {
    (2.0 * visible - 1.0).max(0.01 * visible)
}

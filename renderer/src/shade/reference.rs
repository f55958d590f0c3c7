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
//!
//! Where a depth is inferred the place p, from the eye, may as well be at (1 ± σ) p, with σ a fifth. A
//! photograph that has it at depth z and at the normalised coordinates n of its own frame, of whose
//! axes p has the coordinates (x, y, z_p), would to first order show it `f σ |(x, y) - n z_p| / z` pixels
//! aside. So it is asked for the mean of about as many: what is guessed is shown as finely as it is
//! known, and a photograph where the eye is shows all that it has.

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
/// Share of its distance from the eye by which an inferred place may be off.
pub(crate) const INFERRED_OFF: f64 = 0.2;

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

/// Pixels of a photograph by which a place may be elsewhere in it that is off by a `share` of its distance
/// from the eye. `from_eye`, `from_photograph`: the place, in the axes of the photograph, metres.
/// `focal`: of the photograph, pixels.
pub(crate) fn pixels_off(share: f64, from_eye: DVec3, from_photograph: DVec3, focal: f64) -> f64 {
    let z = from_photograph.z;
    let seen_at = from_photograph.truncate() / z;
    share * focal * (from_eye.truncate() - seen_at * from_eye.z).length() / z
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

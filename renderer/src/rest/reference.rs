//! What is heard of rigs when nearer ones have spoken, in f64.
//!
//! The nearest two rigs speak first. Let S be the sum of their weights at a place. Of another rig's
//! weight w, min(w, max(0, 2 (w - UNHEARD S))) counts: a rig whose share would hardly be seen has none, one
//! of twice as much has all of it, and no share jumps as the eye moves. Where the nearest do not see the place,
//! S is 0 and nothing changes.
//!
//! So a rig needs to be asked only where its weight may exceed UNHEARD S. Equation 4 is greatest where a
//! camera is as near to the place, and its direction as near to the normal, as those of the rig can
//! be, and every other factor of a weight is at most 1. With c between the cameras, none farther from it than r,
//! and d = |c - p|: the distance is at least d - r, and the cosine at most (n · (c - p) + r) / (d - r).

#[cfg(test)]
use glam::DVec3;

#[cfg(test)]
use crate::shade::reference::park_weight;

/// How many of the rigs nearest to the eye speak first.
pub(crate) const NEAREST: usize = 2;
/// Share of what they say that is not heard of others. Photographs of one place differ by a few hundredths, so
/// that this is a fraction of a step of 8 bits: half of it, or an eighth, is no nearer to photographs that were held out.
pub(crate) const UNHEARD: f64 = 1.0 / 32.0;

/// The greatest weight, but for the rig's own share, that any camera of a rig can have at a place where the
/// normal is `n`. The cameras are `reach_m` from `centre` at most; `eye_distance_2` is the square of the rig's
/// distance from the eye, metres.
#[cfg(test)]
pub(crate) fn at_most(
    n: DVec3,
    place: DVec3,
    centre: DVec3,
    reach_m: f64,
    eye_distance_2: f64,
) -> f64 {
    let to_rig = centre - place;
    let distance = (to_rig.length() - reach_m).max(0.0);
    let cosine = ((n.dot(to_rig) + reach_m) / distance).min(1.0);
    // Of a place at that distance which is seen at that cosine.
    let aside = (1.0 - cosine.powi(2)).max(0.0).sqrt();
    let seen_from = distance * DVec3::new(aside, 0.0, cosine);
    park_weight(DVec3::Z, DVec3::ZERO, seen_from, eye_distance_2)
}

/// What is heard of a weight. `said`: the weight of the nearest rigs.
pub(crate) fn heard(weight: f64, said: f64) -> f64 {
    (2.0 * (weight - UNHEARD * said)).clamp(0.0, weight)
}

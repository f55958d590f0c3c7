//! By how much a part lowers the expected error of the picture: the model of [`crate::plan`]'s
//! order.

use flaneur_scene::View;

use crate::choose::{WantedImage, WantedNode};

/// Octaves of a picture that the first level of an image brings: from its mean colour on.
const FIRST_OCTAVES: f64 = 6.0;
/// Octaves of depth that the coarsest points bring: what stands there at all.
const COARSEST_OCTAVES: f64 = 4.0;
/// What points gain where no parallax shows, as a share: what hides what.
const LEAST_PARALLAX: f64 = 0.02;
/// What points gain that the view does not see, as a share: they hide things from photographs.
const UNSEEN: f64 = 0.1;
/// From the eye to a photograph, metres, where there is none.
const NO_PHOTOGRAPH_M: f64 = 50.0;

/// Of an image: its share of the picture times the octaves from the level `from` to the level `to`;
/// `None` for an image of which nothing is there.
pub(super) fn of_image(image: &WantedImage, from: Option<u32>, to: u32) -> f64 {
    let octaves = from.map_or(FIRST_OCTAVES, |from| f64::from(from.saturating_sub(to)));
    image.share * octaves
}

/// Of a node: the share of the picture that its points cover, times how far they displace
/// what a photograph `baseline_m` away shows there, in pixels and at most 1.
pub(super) fn of_node(wanted: &WantedNode, view: &View, baseline_m: Option<f64>) -> f64 {
    let distance = wanted.distance_m.max(1.0);
    let density = view.pixels_a_metre(distance);
    let size = view.size().as_dvec2();
    let spacing_px = wanted.spacing_m * density;
    let covered = f64::from(wanted.node.point_count) * spacing_px * spacing_px / (size.x * size.y);
    let baseline = baseline_m.unwrap_or(NO_PHOTOGRAPH_M);
    let parallax_px = spacing_px * baseline / (distance + baseline);
    let octaves = if wanted.id.key.level <= 1 { COARSEST_OCTAVES } else { 1.0 };
    let seen = if wanted.seen { 1.0 } else { UNSEEN };
    covered.min(1.0) * parallax_px.clamp(LEAST_PARALLAX, 1.0) * octaves * seen
}

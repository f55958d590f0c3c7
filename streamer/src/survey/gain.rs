//! By how much a part lowers the expected error of the picture: the model of [`crate::plan`]'s
//! order.

use flaneur_scene::View;
use glam::DVec2;

use crate::choose::{WantedImage, WantedNode};

/// Octaves of a picture that the first level of an image brings: from its mean colour on.
const FIRST_OCTAVES: f64 = 6.0;
/// What a tile of mesh shows of itself: so wide and high, metres.
const TILE_M: DVec2 = DVec2::new(64.0, 12.0);
/// Octaves of a picture that mesh brings where there is nothing else to project photographs onto.
const TILE_OCTAVES: f64 = 2.0;
/// Octaves of depth that the coarsest points bring: what stands there at all.
const COARSEST_OCTAVES: f64 = 1.5;
/// What an octave of depth counts beside an octave of a photograph. From walks over a synthetic street
/// and one in Paris: between a half and 1 both reach a similarity of 0.9 after the fewest
/// bytes.
const POINTS: f64 = 0.7;
/// A point shows no more than so much around it, metres.
const LARGEST_SPLAT_M: f64 = 0.5;
/// What points gain where no parallax shows, as a share: what hides what.
const LEAST_PARALLAX: f64 = 0.02;
/// What points gain that the view does not see, as a share: they hide things from photographs.
const UNSEEN: f64 = 0.1;
/// From the eye to a photograph, metres, where there is none.
const NO_PHOTOGRAPH_M: f64 = 50.0;

/// Of an image: the octaves that the level `to` adds to the level `from` where the view can show
/// them, times the share of the picture; `None` for an image of which nothing is there.
pub(super) fn of_image(image: &WantedImage, from: Option<u32>, to: u32) -> f64 {
    let lacking = |level: u32| image.lacking.get(level as usize).copied().unwrap_or(0.0);
    match from {
        None => image.share * FIRST_OCTAVES,
        Some(from) => lacking(from) - lacking(to),
    }
}

/// Of a tile of mesh `distance_m` away: the share of the picture that it covers, as a front of a
/// street does.
pub(super) fn of_tile(distance_m: f64, view: &View) -> f64 {
    let density = view.pixels_a_metre(distance_m.max(1.0));
    let size = view.size().as_dvec2();
    (TILE_M.x * TILE_M.y * density * density / (size.x * size.y)).min(1.0) * TILE_OCTAVES
}

/// Of a node: the share of the picture that its points cover, times how far they displace
/// what a photograph `baseline_m` away shows there, in pixels and at most 1.
pub(super) fn of_node(wanted: &WantedNode, view: &View, baseline_m: Option<f64>) -> f64 {
    let distance = wanted.distance_m.max(1.0);
    let density = view.pixels_a_metre(distance);
    let size = view.size().as_dvec2();
    let spacing_px = wanted.spacing_m * density;
    let shown_px = wanted.spacing_m.min(LARGEST_SPLAT_M) * density;
    let covered = f64::from(wanted.node.point_count) * shown_px * shown_px / (size.x * size.y);
    let baseline = baseline_m.unwrap_or(NO_PHOTOGRAPH_M);
    let parallax_px = spacing_px * baseline / (distance + baseline);
    let octaves = if wanted.id.key.level <= 1 { COARSEST_OCTAVES } else { 1.0 };
    let seen = if wanted.seen { 1.0 } else { UNSEEN };
    covered.min(1.0) * parallax_px.clamp(LEAST_PARALLAX, 1.0) * octaves * seen * POINTS
}

//! By how much images and mesh lower the expected error of the picture: the model of [`crate::plan`]'s
//! order.

use flaneur_scene::View;
use glam::DVec2;

use crate::choose::WantedImage;

/// Octaves of a picture that the first level of an image brings: from its mean colour on.
pub(super) const FIRST_OCTAVES: f64 = 6.0;
/// What a tile of mesh shows of itself: so wide and high, metres.
const TILE_M: DVec2 = DVec2::new(64.0, 12.0);
/// Octaves of a picture that mesh brings where there is nothing else to project photographs onto.
const TILE_OCTAVES: f64 = 2.0;

/// Of an image: the octaves that the level `to` adds to the level `from` where the view can show
/// them, times the share of the picture; `None` for an image of which nothing is there.
pub(super) fn of_image(image: &WantedImage, from: Option<u32>, to: u32) -> f64 {
    let lacking = |level: u32| image.lacking.get(level as usize).copied().unwrap_or(0.0);
    match from {
        None => image.share * FIRST_OCTAVES,
        Some(from) => lacking(from) - lacking(to),
    }
}

/// Of knowing the panoramas of a district `distance_m` away, where the nearest one that is known is
/// `nearest_m` from the eye: were there one, it would decide of the picture what two photographs at these
/// distances share by their squares.
pub(super) fn of_district(distance_m: f64, nearest_m: f64) -> f64 {
    let near = nearest_m.max(1.0).powi(2);
    near / (near + distance_m.powi(2)) * FIRST_OCTAVES
}

/// Of a tile of mesh `distance_m` away: the share of the picture that it covers, as a front of a
/// street does.
pub(super) fn of_tile(distance_m: f64, view: &View) -> f64 {
    let density = view.pixels_a_metre(distance_m.max(1.0));
    let size = view.size().as_dvec2();
    (TILE_M.x * TILE_M.y * density * density / (size.x * size.y)).min(1.0) * TILE_OCTAVES
}

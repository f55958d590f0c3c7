//! Windows with their frames, shutters and balconies.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Class;
use super::facade::{Opening, Skin};
use super::model::{Model, Place};
use super::style::Style;
use crate::geometry::Cutout;
use crate::look::Material;

/// How far the pane lies behind the wall's face.
pub(crate) const RECESS_M: f64 = 0.24;
const RAIL_M: f64 = 1.0;

/// A window in its opening: the pane behind, frame, sill, surround and shutters.
pub(crate) fn window(
    model: &mut Model,
    storey: &Place,
    hole: &Opening,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    let seed = rng.random::<u32>();
    glaze(model, storey, hole, 2, skin, seed);
    let (left, right) = (hole.left, hole.left + hole.width);
    let (low, high) = (hole.bottom, hole.bottom + hole.height);
    let mut trim = |from: [f64; 3], to: [f64; 3]| model.push(storey.block(from, to), skin.trim);
    trim([left - 0.08, -RECESS_M + 0.05, low - 0.07], [right + 0.08, 0.08, low]);
    if style.surrounds {
        trim([left - 0.14, 0.0, low], [left, 0.035, high]);
        trim([right, 0.0, low], [right + 0.14, 0.035, high]);
        trim([left - 0.2, 0.0, high], [right + 0.2, 0.055, high + 0.17]);
    }
    let room = 0.5 * (style.bay_m - style.window_m) > 0.45;
    if let (Some(shutter), true) = (skin.shutter, room) {
        let width = 0.5 * hole.width;
        // Open against the wall, or closed over the opening.
        let closed = rng.random_bool(0.12);
        let lefts = if closed { [left, left + width] } else { [left - width, right] };
        let out = if closed { -0.02 } else { 0.04 };
        for from in lefts {
            model.push(
                storey.block([from + 0.01, out, low], [from + width - 0.01, out + 0.04, high]),
                shutter,
            );
        }
    }
}

/// The pane with its frame: casements of equal width, a transom at two thirds where tall.
pub(crate) fn glaze(
    model: &mut Model,
    storey: &Place,
    hole: &Opening,
    casements: u32,
    skin: &Skin,
    seed: u32,
) {
    let size = glam::DVec2::new(hole.width, hole.height);
    let pane = model.surface(Class::Window, Material::Pane { size, seed });
    model.push(storey.pane([hole.left, -RECESS_M, hole.bottom], hole.width, hole.height), pane);
    let (low, high) = (hole.bottom, hole.bottom + hole.height);
    let mut bar = |from: f64, to: f64, low: f64, high: f64| {
        model
            .push(storey.block([from, -RECESS_M, low], [to, -RECESS_M + 0.05, high]), skin.joinery);
    };
    let right = hole.left + hole.width;
    bar(hole.left, hole.left + 0.06, low, high);
    bar(right - 0.06, right, low, high);
    bar(hole.left, right, low, low + 0.07);
    bar(hole.left, right, high - 0.06, high);
    for i in 1..casements {
        let middle = hole.left + hole.width * f64::from(i) / f64::from(casements);
        bar(middle - 0.045, middle + 0.045, low, high);
    }
    for i in 1..(hole.height / 0.7).round() as u32 {
        let at = low + 0.7 * f64::from(i);
        if high - at > 0.3 {
            bar(hole.left, right, at - 0.018, at + 0.018);
        }
    }
}

/// A slab with a railing on three sides, at the storey's floor.
pub(crate) fn balcony(model: &mut Model, place: &Place, width_m: f64, depth_m: f64, skin: &Skin) {
    model.push(place.block([0.0, 0.0, -0.14], [width_m, depth_m, 0.02]), skin.trim);
    // Brackets below.
    let count = (width_m / 1.6).ceil().max(1.0) as u32;
    for i in 0..=count {
        let along = 0.1 + (width_m - 0.3) * f64::from(i) / f64::from(count);
        model.push(
            place.block([along, 0.0, -0.42], [along + 0.12, 0.6 * depth_m, -0.14]),
            skin.trim,
        );
    }
    let cutout = Cutout::Railing { height_m: RAIL_M, pitch_m: 0.115, bar_m: 0.022 };
    let out = depth_m - 0.05;
    let up = [0.0, 0.0, RAIL_M];
    for (corner, side) in [
        ([0.03, out, 0.02], [width_m - 0.06, 0.0, 0.0]),
        ([0.03, 0.0, 0.02], [0.0, out, 0.0]),
        ([width_m - 0.03, out, 0.02], [0.0, -out, 0.0]),
    ] {
        model.push_cut(place.sheet(corner, side, up), skin.iron, cutout);
    }
    let rail = place.block([0.0, out - 0.03, RAIL_M], [width_m, out + 0.03, RAIL_M + 0.05]);
    model.push(rail, skin.iron);
}

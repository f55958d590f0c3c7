//! Roofs, dormers and chimneys.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::facade::{Opening, Skin};
use super::model::{Model, Place};
use super::style::{RoofKind, Style};
use super::window::{RECESS_M, glaze};
use crate::geometry::Shape;

/// Covers a part; `place` is at the eaves.
pub(crate) fn raise_roof(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    depth_m: f64,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    let ridge_m = match style.roof {
        RoofKind::Mansard => {
            let profile = [(0.02, 0.0), (-1.1, 2.3), (-0.5 * depth_m, 3.2), (-depth_m, 2.0)];
            sweep(model, place, width_m, &profile, skin.zinc, skin.party_wall);
            dormers(model, place, width_m, style, skin, rng);
            3.2
        }
        RoofKind::Gable => {
            let rise = 0.5 * depth_m * rng.random_range(0.5..0.7);
            let profile = [(0.38, -0.06), (-0.5 * depth_m, rise), (-depth_m - 0.3, -0.06)];
            sweep(model, place, width_m, &profile, skin.tiles, skin.party_wall);
            rise
        }
        RoofKind::Terrace => {
            model.push(place.block([0.0, -0.25, 0.0], [width_m, 0.0, 0.85]), skin.wall);
            model.push(place.block([-0.02, -0.3, 0.85], [width_m + 0.02, 0.05, 0.95]), skin.trim);
            setback(model, &place.moved(0.0, -2.2, 0.0), width_m, depth_m - 2.2, style, skin, rng);
            2.9
        }
    };
    chimney(model, place, width_m, depth_m, ridge_m, skin, rng);
}

/// Extrudes a profile of (out, up) corners along the part; its ends are closed by fans
/// from the first corner, so the profile must be convex.
fn sweep(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    profile: &[(f64, f64)],
    cover: u32,
    end: u32,
) {
    for pair in profile.windows(2) {
        let ((out0, up0), (out1, up1)) = (pair[0], pair[1]);
        let shape =
            place.sheet([0.0, out0, up0], [width_m, 0.0, 0.0], [0.0, out1 - out0, up1 - up0]);
        model.push(shape, cover);
    }
    let first = profile[0];
    for pair in profile[1..].windows(2) {
        for along in [0.0, width_m] {
            let corner = |(out, up): (f64, f64)| place.at(along, out, up);
            model.push(Shape::triangle(corner(first), corner(pair[0]), corner(pair[1])), end);
        }
    }
}

/// Small gabled windows in the steep slope of a mansard.
fn dormers(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    let count = (width_m / (1.5 * style.bay_m)).floor().max(1.0) as u32;
    for i in 0..count {
        let middle = (f64::from(i) + 0.5) * width_m / f64::from(count);
        let front = place.moved(middle - 0.6, -0.2, 0.25);
        // Cheeks, sill and head around the window, the body behind it.
        for (low, high) in [
            ([0.0, -1.6, 0.0], [1.2, -RECESS_M, 1.7]),
            ([0.0, -RECESS_M, 0.0], [0.12, 0.0, 1.7]),
            ([1.08, -RECESS_M, 0.0], [1.2, 0.0, 1.7]),
            ([0.12, -RECESS_M, 1.55], [1.08, 0.0, 1.7]),
            ([0.12, -RECESS_M, 0.0], [1.08, 0.03, 0.1]),
        ] {
            model.push(front.block(low, high), skin.zinc);
        }
        let hole = Opening { left: 0.12, bottom: 0.1, width: 0.96, height: 1.45 };
        // In front of the body's face, which the pane would otherwise coincide with.
        glaze(model, &front.moved(0.0, 0.02, 0.0), &hole, 2, skin, rng.random());
        model.push(front.block([-0.1, -1.6, 1.7], [1.3, 0.14, 1.8]), skin.zinc);
    }
}

/// The storey behind a terrace: a real step in height that one number cannot tell.
fn setback(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    depth_m: f64,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    model.push(place.block([0.0, -depth_m, 0.0], [width_m, 0.0, 2.7]), skin.party_wall);
    model.push(place.block([-0.0, -depth_m, 2.7], [width_m, 0.35, 2.88]), skin.zinc);
    let count = (width_m / 3.2).floor().max(1.0) as u32;
    for i in 0..count {
        let middle = (f64::from(i) + 0.5) * width_m / f64::from(count);
        let hole = Opening { left: middle - 1.0, bottom: 0.1, width: 2.0, height: 2.2 };
        glaze(model, &place.moved(0.0, RECESS_M + 0.02, 0.0), &hole, 2, skin, rng.random());
    }
    let rail = crate::geometry::Cutout::Railing { height_m: 0.5, pitch_m: 0.115, bar_m: 0.02 };
    let front = place.moved(0.0, 2.05, 0.95);
    if style.seed.is_multiple_of(2) {
        model.push_cut(front.pane([0.0, 0.0, 0.0], width_m, 0.5), skin.iron, rail);
    }
}

fn chimney(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    depth_m: f64,
    ridge_m: f64,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    if width_m < 3.5 {
        return;
    }
    let along = if rng.random_bool(0.5) { 0.05 } else { width_m - 0.6 };
    let out = -depth_m * rng.random_range(0.25..0.5);
    let top = ridge_m + rng.random_range(0.7..1.3);
    let length = rng.random_range(0.9..1.9);
    model.push(place.block([along, out - length, -0.5], [along + 0.55, out, top]), skin.wall);
    for i in 0..(length / 0.36).floor() as u32 {
        let foot = place.at(along + 0.28, out - 0.2 - 0.36 * f64::from(i), top);
        model.post(foot, 0.42, 0.11, skin.tiles);
    }
}

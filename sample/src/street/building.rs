//! A building: a facade in relief, party walls, a roof, and the box a cadastre makes of it.

use glam::DVec2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::facade::{Skin, raise_facade};
use super::model::{Model, Place};
use super::roof::raise_roof;
use super::style::{RoofKind, Style};

/// How far from the real walls the cadastre's outline may be, metres.
pub(crate) const FOOTPRINT_ERROR_M: f64 = 0.45;

/// A building as the cadastre knows it, with what it got wrong.
#[derive(Clone, Debug)]
pub(crate) struct Building {
    /// Outline in the street frame, counter-clockwise.
    pub(crate) outline: [DVec2; 4],
    /// Height of the foot above the street frame's zero.
    pub(crate) base_m: f64,
    /// Height above the foot, as published.
    pub(crate) height_m: f64,
    /// How far the real facade stands in front of the outline (negative: behind it).
    pub(crate) facade_offset_m: f64,
    /// Real heights of the eaves of its parts above the foot.
    pub(crate) eaves_m: Vec<f64>,
}

/// Raises a building of this width and depth and gives its record.
///
/// `place` is at the left foot of the real facade. A third of the buildings have two parts
/// of different heights, which the cadastre does not tell apart.
pub(crate) fn raise_building(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    depth_m: f64,
    rng: &mut ChaCha8Rng,
) -> Building {
    let style = Style::draw(rng);
    let skin = Skin::new(model, &style);
    let split = width_m > 9.0 && rng.random_bool(0.35);
    let first = if split { width_m * rng.random_range(0.4..0.6) } else { width_m };
    let mut eaves_m = vec![raise_part(model, place, first, depth_m, &style, &skin, rng)];
    if split {
        let lower = rng.random_bool(0.6);
        let floors = if lower { style.floors - 1 } else { style.floors + 1 };
        let part = Style { floors, ..style };
        let beside = place.moved(first, 0.0, 0.0);
        eaves_m.push(raise_part(model, &beside, width_m - first, depth_m, &part, &skin, rng));
    }
    let roof_m = match style.roof {
        RoofKind::Mansard => 1.2,
        RoofKind::Gable => 0.8,
        RoofKind::Terrace => 0.0,
    };
    let mut error = |limit: f64| rng.random_range(-limit..limit);
    let facade_offset_m = error(FOOTPRINT_ERROR_M);
    let (shift, deeper) = (error(0.15), error(0.4));
    let corner = |along: f64, out: f64| place.at(along + shift, out, 0.0).truncate();
    let (front, back) = (-facade_offset_m, -depth_m + deeper);
    Building {
        outline: [
            corner(0.0, front),
            corner(0.0, back),
            corner(width_m, back),
            corner(width_m, front),
        ],
        base_m: place.origin.z,
        height_m: eaves_m[0] + roof_m + error(0.3),
        facade_offset_m,
        eaves_m,
    }
}

/// Raises one part and gives the height of its eaves.
fn raise_part(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    depth_m: f64,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) -> f64 {
    let eaves_m = style.eaves_m();
    // The core behind the facade: party walls and back. It reaches below the ground so
    // that no slope of the street leaves a gap under it.
    let core = place.block([0.0, -depth_m, -2.0], [width_m, -super::facade::WALL_M, eaves_m]);
    model.push(core, skin.party_wall);
    raise_facade(model, place, width_m, style, skin, rng);
    raise_roof(model, &place.moved(0.0, 0.0, eaves_m), width_m, depth_m, style, skin, rng);
    eaves_m
}

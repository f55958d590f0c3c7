//! What stands at street level: shops with signs and awnings, or windows and a door.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Class;
use super::facade::{Opening, Skin, bays, wall};
use super::model::{Model, Place};
use super::style::{Style, pick};
use super::window::{RECESS_M, glaze, window};
use crate::look::Material;

const DOOR_M: DVec2 = DVec2::new(1.15, 2.75);

/// Shop windows over a low base, a door, a sign above, and maybe an awning.
pub(crate) fn shop_front(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    let colour = pick(
        rng,
        &[
            [0.05, 0.12, 0.08],
            [0.20, 0.03, 0.03],
            [0.03, 0.06, 0.16],
            [0.42, 0.30, 0.06],
            [0.06, 0.06, 0.06],
            [0.10, 0.30, 0.34],
            [0.48, 0.45, 0.40],
        ],
    );
    let front = model.surface(Class::Building, Material::Paintwork { colour });
    let head = style.ground_floor_m - 1.0;
    let glass_left = 0.55;
    let glass_right = width_m - 0.55;
    let door_left = if rng.random_bool(0.5) { glass_left } else { glass_right - DOOR_M.x };
    let hole =
        Opening { left: glass_left, bottom: 0.0, width: glass_right - glass_left, height: head };
    wall(model, place, width_m, style.ground_floor_m, &[hole], skin.wall);
    let (from, to) = if door_left > glass_left {
        (glass_left, door_left)
    } else {
        (door_left + DOOR_M.x, glass_right)
    };
    model.push(place.block([from, -RECESS_M - 0.05, 0.0], [to, -0.06, 0.5]), front);
    let panes = ((to - from) / 1.9).round().max(1.0) as u32;
    let seed = rng.random::<u32>();
    let show = Opening { left: from, bottom: 0.5, width: to - from, height: head - 0.5 };
    shop_window(model, place, &show, panes, front, seed);
    let door = Opening { left: door_left, bottom: 0.0, width: DOOR_M.x, height: head };
    shop_window(model, place, &door, 1, front, seed ^ 1);
    for left in [glass_left - 0.28, glass_right - 0.04] {
        model.push(place.block([left, 0.0, 0.0], [left + 0.32, 0.09, head + 0.05]), front);
    }
    let size = DVec2::new(width_m - 0.54, 0.62);
    model.push(place.block([0.27, 0.0, head + 0.05], [width_m - 0.27, 0.14, head + 0.67]), front);
    let sign = model.surface(Class::Building, Material::Sign { colour, size, seed });
    model.push(place.pane([0.27, 0.141, head + 0.05], size.x, size.y), sign);
    model.push(place.block([0.2, 0.0, head + 0.67], [width_m - 0.2, 0.24, head + 0.76]), skin.trim);
    if style.awning {
        awning(model, place, width_m, head, colour, rng);
    }
}

fn shop_window(
    model: &mut Model,
    place: &Place,
    hole: &Opening,
    panes: u32,
    frame: u32,
    seed: u32,
) {
    let size = DVec2::new(hole.width, hole.height);
    let glass = model.surface(Class::Window, Material::Display { size, seed });
    model.push(place.pane([hole.left, -RECESS_M, hole.bottom], size.x, size.y), glass);
    for i in 0..=panes {
        let at = hole.left + hole.width * f64::from(i) / f64::from(panes);
        let from = (at - 0.035).max(hole.left);
        let to = (at + 0.035).min(hole.left + hole.width);
        let high = hole.bottom + hole.height;
        model
            .push(place.block([from, -RECESS_M, hole.bottom], [to, -RECESS_M + 0.07, high]), frame);
    }
    for up in [hole.bottom, hole.bottom + hole.height - 0.62, hole.bottom + hole.height - 0.07] {
        model.push(
            place.block(
                [hole.left, -RECESS_M, up],
                [hole.left + hole.width, -RECESS_M + 0.06, up + 0.07],
            ),
            frame,
        );
    }
}

fn awning(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    head: f64,
    colour: DVec3,
    rng: &mut ChaCha8Rng,
) {
    let stripes = rng.random_bool(0.6);
    let cloth = model.surface(Class::Building, Material::Awning { colour, stripes });
    let (left, width) = (0.4, width_m - 0.8);
    let (reach, drop) = (rng.random_range(0.9..1.3), 0.55);
    let front = place.sheet([left, 0.1, head - 0.02], [width, 0.0, 0.0], [0.0, reach, -drop]);
    model.push(front, cloth);
    let valance =
        place.sheet([left, 0.1 + reach, head - 0.02 - drop], [width, 0.0, 0.0], [0.0, 0.0, -0.22]);
    model.push(valance, cloth);
}

/// Windows in the bays, and a door in one of them.
pub(crate) fn dwelling_front(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    let bays = bays(width_m, style);
    let door_bay = rng.random_range(0..bays.len());
    let openings: Vec<Opening> = bays
        .iter()
        .enumerate()
        .map(|(i, &middle)| {
            let (width, bottom, height) =
                if i == door_bay { (DOOR_M.x, 0.0, DOOR_M.y) } else { (style.window_m, 1.05, 1.6) };
            Opening { left: middle - 0.5 * width, bottom, width, height }
        })
        .collect();
    wall(model, place, width_m, style.ground_floor_m, &openings, skin.wall);
    for (i, hole) in openings.iter().enumerate() {
        if i == door_bay {
            door(model, place, hole, skin, rng);
        } else {
            window(model, place, hole, style, skin, rng);
        }
    }
    // A plinth, interrupted by the door.
    let gap = &openings[door_bay];
    for (from, to) in [(0.0, gap.left - 0.15), (gap.left + gap.width + 0.15, width_m)] {
        if to > from {
            model.push(place.block([from, 0.0, -1.0], [to, 0.06, 0.62]), skin.trim);
        }
    }
}

fn door(model: &mut Model, place: &Place, hole: &Opening, skin: &Skin, rng: &mut ChaCha8Rng) {
    let colour = pick(
        rng,
        &[[0.04, 0.10, 0.07], [0.18, 0.03, 0.03], [0.04, 0.07, 0.15], [0.20, 0.10, 0.05]],
    );
    let size = DVec2::new(hole.width, 2.15);
    let leaf = model.surface(Class::Building, Material::Door { colour, size });
    model.push(place.pane([hole.left, -RECESS_M, 0.0], size.x, size.y), leaf);
    let light = Opening { bottom: size.y, height: hole.height - size.y, ..*hole };
    glaze(model, place, &light, 1, skin, rng.random());
    for left in [hole.left - 0.15, hole.left + hole.width] {
        model.push(place.block([left, 0.0, 0.0], [left + 0.15, 0.07, hole.height]), skin.trim);
    }
    let (from, to) = (hole.left - 0.22, hole.left + hole.width + 0.22);
    model.push(place.block([from, 0.0, hole.height], [to, 0.16, hole.height + 0.2]), skin.trim);
    model.push(place.block([from, -RECESS_M, -0.4], [to, 0.25, 0.04]), skin.trim);
}

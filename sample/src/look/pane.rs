//! Glass, and what is behind it: rooms with curtains, shops with goods.

use glam::{DVec2, DVec3, IVec2};

use super::material::{Appearance, Spot};
use super::noise::{cell, fractal, smooth, unit};

/// A window into a room: walls by parallax, curtains at the sides, some blinds.
pub(crate) fn window(spot: &Spot, size: DVec2, seed: u32) -> Appearance {
    let p = spot.local.truncate() / size;
    let random = |n| unit(seed, n);
    let albedo = if random(0) < 0.18 {
        // A blind, let down part of the way.
        let down = 1.0 - (0.3 + 0.7 * random(1));
        if p.y > down { DVec3::new(0.62, 0.58, 0.48) } else { room(spot, size, 2.2, seed) }
    } else {
        let open = 0.10 + 0.22 * random(2);
        let edge = p.x.min(1.0 - p.x) + 0.015 * (14.0 * p.y).sin() * random(4);
        let folds = 0.8 + 0.2 * (p.x * size.x * 55.0).sin();
        let cloth = DVec3::new(0.55, 0.52, 0.45) * (0.7 + 0.5 * random(3)) * folds;
        let hidden = 1.0 - smooth(open - 0.02, open, edge);
        room(spot, size, 2.2, seed).lerp(cloth * 0.75, hidden * f64::from(random(5) < 0.75))
    };
    Appearance { tilt: ripple(spot, seed), ..Appearance::matt(albedo).coated(0.055) }
}

/// A shop window: shelves of goods near the glass.
pub(crate) fn display(spot: &Spot, size: DVec2, seed: u32) -> Appearance {
    let behind = room(spot, size, 4.0, seed) * 1.5;
    // A shelf 0.5 m behind the pane, seen by parallax.
    let p = parallax(spot, 0.5);
    let shelf = (p.y / 0.62).floor();
    let row = p.y - shelf * 0.62;
    let slot = (p.x / 0.24).floor();
    let at = IVec2::new(slot as i32, shelf as i32);
    let random = |n: u32| cell(at, seed ^ n);
    let (width, height) = (0.05 + 0.06 * random(1), 0.12 + 0.36 * random(2));
    let across = (p.x - (slot + 0.5) * 0.24).abs();
    let goods = random(3) < 0.7 && across < width && row < height;
    let board = row > 0.585;
    let within = p.x > 0.0 && p.x < size.x && p.y > 0.0 && p.y < size.y - 0.7;
    let albedo = match () {
        () if within && goods => {
            let tone = DVec3::new(random(4), random(5), random(6));
            let muted = tone.lerp(DVec3::splat(random(7)), 0.55) * DVec3::new(1.0, 0.93, 0.82);
            muted * muted * 0.6 * (1.0 - 0.45 * (across / width).powi(2)) + 0.02
        }
        () if within && board => DVec3::new(0.20, 0.16, 0.12),
        () => behind,
    };
    Appearance { tilt: ripple(spot, seed), ..Appearance::matt(albedo).coated(0.05) }
}

/// Where the line of sight meets a plane this far behind the pane, on the pane's axes.
fn parallax(spot: &Spot, depth_m: f64) -> DVec2 {
    let inward = (-spot.direction.dot(spot.normal)).max(0.05);
    let right = DVec3::Z.cross(spot.normal);
    let slide = DVec2::new(spot.direction.dot(right), spot.direction.z) / inward;
    spot.local.truncate() + slide * depth_m
}

/// The inside of a room: back wall, side walls, floor and ceiling of a box behind the
/// pane, dark because little light gets in.
fn room(spot: &Spot, size: DVec2, depth_m: f64, seed: u32) -> DVec3 {
    let inward = (-spot.direction.dot(spot.normal)).max(0.05);
    let right = DVec3::Z.cross(spot.normal);
    let slide = DVec2::new(spot.direction.dot(right), spot.direction.z) / inward;
    let (low, high) = (DVec2::new(-1.1, -0.6), size + DVec2::new(1.1, 0.5));
    let p = spot.local.truncate();
    let reach = |p: f64, slide: f64, low: f64, high: f64| {
        if slide > 0.0 { (high - p) / slide } else { (low - p) / slide.min(-1e-9) }
    };
    let across = reach(p.x, slide.x, low.x, high.x);
    let up = reach(p.y, slide.y, low.y, high.y);
    let depth = across.min(up).min(depth_m);
    let tint = DVec3::new(0.26, 0.22, 0.18) * (0.6 + 0.6 * unit(seed, 8));
    let side = match () {
        () if depth >= depth_m => 0.8,
        () if across < up => 0.6,
        () if slide.y > 0.0 => 1.1,
        () => 0.35,
    };
    tint * side * (0.75 * (-0.55 * depth).exp() + 0.06)
}

/// Old glass is not quite flat: its reflections waver.
fn ripple(spot: &Spot, seed: u32) -> DVec2 {
    let p = spot.local.truncate();
    let lean = DVec2::new(unit(seed, 20) - 0.5, unit(seed, 21) - 0.5) * 0.03;
    let wave = |n| 0.016 * fractal(p, 0.7, 2, 0.0, seed ^ n);
    lean + DVec2::new(wave(22), wave(23))
}

//! Walls, doors, signs and roofs.

use glam::{DVec2, DVec3, IVec2};

use super::material::{Appearance, Spot};
use super::noise::{cell, fade, fractal, smooth};

/// Render: blotches, streaks below sills, fine grain, dirt near the ground.
pub(crate) fn plaster(p: DVec2, colour: DVec3, f: f64, seed: u32) -> Appearance {
    let blotches = fractal(p, 3.1, 6, f, seed);
    let streaks = fractal(p * DVec2::new(4.0, 0.35), 1.3, 4, f, seed ^ 3);
    let grain = fractal(p, 0.035, 3, f, seed ^ 5);
    let shade = 1.0 + 0.20 * blotches + 0.14 * streaks + 0.16 * grain;
    Appearance { tilt: relief(p, 0.045, 0.055, f, seed), ..Appearance::matt(colour * shade) }
}

/// Bricks of 22 × 6.5 cm with 1 cm joints, each fired a little differently.
pub(crate) fn brick(p: DVec2, colour: DVec3, f: f64, seed: u32) -> Appearance {
    let size = DVec2::new(0.23, 0.075);
    let row = (p.y / size.y).floor();
    let shifted = DVec2::new(p.x / size.x + 0.5 * row.rem_euclid(2.0), p.y / size.y);
    let inside = shifted.rem_euclid(DVec2::ONE);
    let to_edge = (inside.min(1.0 - inside) * size).min_element();
    let seen = fade(0.07, f);
    let mortar = 1.0 - smooth(0.0035, 0.0065 + 0.4 * f, to_edge);
    let brick = shifted.floor().as_ivec2();
    let firing = 1.0 + seen * 0.75 * (cell(brick, seed) - 0.5);
    let hue = DVec3::new(1.0, 1.0 + 0.25 * seen * (cell(brick, seed ^ 1) - 0.5), 1.0);
    let weather = 1.0 + 0.22 * fractal(p, 2.7, 5, f, seed ^ 2);
    let grain = 1.0 + 0.2 * fractal(p, 0.03, 3, f, seed ^ 5);
    let joint = DVec3::new(0.50, 0.47, 0.42) * grain;
    // Where bricks are too small to see, their mean with the mortar remains.
    let share = seen * mortar + (1.0 - seen) * 0.14;
    let face = colour * hue * firing * grain;
    let tilt = DVec2::new(0.0, 0.5 * seen * mortar * (inside.y - 0.5).signum());
    Appearance { tilt, ..Appearance::matt(face.lerp(joint, share) * weather) }
}

/// Ashlar in courses of 0.38 m.
pub(crate) fn stone(p: DVec2, colour: DVec3, f: f64, seed: u32) -> Appearance {
    let height = 0.38;
    let row = (p.y / height).floor();
    let length = 0.7 + 0.35 * cell(IVec2::new(0, row as i32), seed);
    let shifted = DVec2::new(p.x / length + 0.37 * row.rem_euclid(3.0), p.y / height);
    let inside = shifted.rem_euclid(DVec2::ONE);
    let to_edge = (inside.min(1.0 - inside) * DVec2::new(length, height)).min_element();
    let joint = (1.0 - smooth(0.004, 0.009 + 0.5 * f, to_edge)) * fade(0.25, f);
    let block = 1.0 + 0.17 * (cell(shifted.floor().as_ivec2(), seed ^ 1) - 0.5);
    let veins = 1.0 + 0.22 * fractal(p * DVec2::new(1.0, 2.2), 0.9, 6, f, seed ^ 2);
    let soot = 1.0 + 0.18 * fractal(p, 4.0, 3, f, seed ^ 4);
    let shade = block * veins * soot * (1.0 - 0.45 * joint);
    Appearance { tilt: relief(p, 0.08, 0.08, f, seed), ..Appearance::matt(colour * shade) }
}

/// A leaf of four raised panels with a knob.
pub(crate) fn door(spot: &Spot, colour: DVec3, size: DVec2) -> Appearance {
    let p = spot.local.truncate();
    let middle = (p.x - 0.5 * size.x).abs();
    let knob = (p - DVec2::new(0.86 * size.x, 0.48 * size.y)).length();
    if knob < 0.04 {
        return Appearance::matt(DVec3::new(0.45, 0.34, 0.12)).coated(0.2);
    }
    let half = DVec2::new(0.5 * size.x, size.y / 3.0);
    let inside = p.rem_euclid(half);
    let to_edge = inside.min(half - inside).min_element();
    let groove = 1.0 - 0.55 * (1.0 - smooth(0.012, 0.03, (to_edge - 0.09).abs()));
    let gap = if middle < 0.006 { 0.3 } else { 1.0 };
    let kick = if p.y < 0.22 { 0.7 } else { 1.0 };
    let grain = 1.0 + 0.15 * fractal(p * DVec2::new(8.0, 1.0), 0.4, 4, spot.footprint_m, 31);
    Appearance::matt(colour * (1.25 * groove * gap * kick * grain)).coated(0.03)
}

/// A shop's name in an alphabet of our own: glyphs of three by five strokes.
pub(crate) fn sign(spot: &Spot, colour: DVec3, size: DVec2, seed: u32) -> Appearance {
    let p = spot.local.truncate();
    let height = 0.55 * size.y;
    let width = 0.72 * height;
    let letters = (5.0 + (6.0 * cell(IVec2::ZERO, seed)).floor())
        .min((0.9 * size.x / width).floor())
        .max(1.0);
    let start = 0.5 * (size.x - letters * width);
    let at = DVec2::new((p.x - start) / width, (p.y - 0.22 * size.y) / height);
    let pale = colour.element_sum() < 0.7;
    let ink = if pale { DVec3::new(0.72, 0.66, 0.50) } else { DVec3::splat(0.03) };
    let border = (p.min(size - p).min_element() - 0.045).abs() < 0.012;
    let within = at.x >= 0.0 && at.x < letters && at.y >= 0.0 && at.y < 1.0;
    let glyph = at.x.floor() as i32;
    let stroke = DVec2::new(at.x.rem_euclid(1.0) / 0.78 * 3.0, at.y * 5.0).floor().as_ivec2();
    let space = cell(IVec2::new(glyph, -1), seed) < 0.1;
    // The outer strokes are mostly there, the middle ones half of the time.
    let likely = if stroke.x == 1 { 0.45 } else { 0.72 };
    let drawn = within
        && !space
        && stroke.x < 3
        && cell(IVec2::new(glyph * 8 + stroke.x, stroke.y), seed ^ 9) < likely;
    Appearance::matt(if drawn || border { ink } else { colour }).coated(0.02)
}

/// Overlapping clay tiles, 20 cm wide and 30 cm up the slope.
pub(crate) fn tiles(spot: &Spot, f: f64, seed: u32) -> Appearance {
    let size = DVec2::new(0.2, 0.3);
    let p = spot.local.truncate();
    let row = (p.y / size.y).floor();
    let shifted = DVec2::new(p.x / size.x + 0.5 * row.rem_euclid(2.0), p.y / size.y);
    let inside = shifted.rem_euclid(DVec2::ONE);
    let seen = fade(0.18, f);
    let tile = 1.0 + seen * 0.5 * (cell(shifted.floor().as_ivec2(), seed) - 0.5);
    let lip = 1.0 - seen * 0.6 * (1.0 - smooth(0.0, 0.16, inside.y));
    let round = 1.0 - seen * 0.35 * (2.0 * inside.x - 1.0).powi(2);
    let moss = 1.0 + 0.3 * fractal(p, 2.0, 5, f, seed ^ 2);
    Appearance::matt(DVec3::new(0.37, 0.155, 0.085) * tile * lip * round * moss)
}

/// Sheets of zinc with a standing seam every 60 cm.
pub(crate) fn zinc(spot: &Spot, f: f64, seed: u32) -> Appearance {
    let p = if spot.normal.z > 0.2 { spot.local.truncate() } else { spot.plan() };
    let across = (p.x / 0.6).rem_euclid(1.0);
    let seam = across.min(1.0 - across) * 0.6;
    let line = (1.0 - smooth(0.012, 0.02 + 0.5 * f, seam)) * fade(0.2, f);
    let sheet = 1.0 + 0.1 * (cell(DVec2::new((p.x / 0.6).floor(), 0.0).as_ivec2(), seed) - 0.5);
    let bloom = 1.0 + 0.2 * fractal(p, 1.4, 5, f, seed ^ 2);
    let albedo = DVec3::new(0.27, 0.30, 0.33) * sheet * bloom * (1.0 - 0.4 * line);
    Appearance::matt(albedo).coated(0.01)
}

/// Slopes of a rough surface, from differences of noise.
fn relief(p: DVec2, size_m: f64, slope: f64, f: f64, seed: u32) -> DVec2 {
    let seen = fade(size_m, f);
    if seen <= 0.0 {
        return DVec2::ZERO;
    }
    let at = |offset: DVec2| super::noise::value((p + offset) / size_m, seed ^ 77);
    let step = 0.3 * size_m;
    let middle = at(DVec2::ZERO);
    DVec2::new(at(DVec2::X * step) - middle, at(DVec2::Y * step) - middle) * (slope * seen / 0.3)
}

//! Asphalt with its markings, paving slabs and kerb stones.

use glam::{DVec2, DVec3};

use super::material::{Appearance, Spot};
use super::noise::{cell, fade, fractal, smooth};
use crate::street::KERB_M;

/// Asphalt: grains, patches, cracks, wheel tracks, covers, and white markings.
pub(crate) fn road(spot: &Spot, length_m: f64) -> Appearance {
    let (p, f) = (spot.position.truncate(), spot.footprint_m);
    let grain = fractal(p, 0.04, 3, f, 11);
    let wear = fractal(p * DVec2::new(0.35, 1.0), 2.6, 5, f, 12);
    let mut shade = 0.105 * (1.0 + 0.55 * grain + 0.45 * wear);
    // Repairs: dark rectangles, one in five cells.
    let patch = (p / DVec2::new(7.3, 3.1)).floor().as_ivec2();
    if cell(patch, 13) < 0.2 {
        let inside = (p / DVec2::new(7.3, 3.1)).rem_euclid(DVec2::ONE) * DVec2::new(7.3, 3.1);
        let size = DVec2::new(1.0 + 3.0 * cell(patch, 14), 0.7 + 1.2 * cell(patch, 15));
        if inside.cmplt(size).all() {
            shade *= 0.72;
        }
    }
    // Cracks follow the zero lines of a slow noise.
    let crack = fractal(p + 0.3 * grain, 3.7, 4, f, 16).abs();
    shade *= 1.0 - 0.55 * fade(0.03, f) * (1.0 - smooth(0.0, 0.012, crack));
    // Gutters collect dirt.
    let edge = KERB_M - p.y.abs();
    shade *= 1.0 - 0.3 * (1.0 - smooth(0.0, 0.5, edge)) * f64::from(edge > 0.0);
    let mut colour = DVec3::new(1.0, 0.99, 0.96) * shade;
    let paint = marking(p, length_m, f) * (0.80 + 0.5 * wear).clamp(0.25, 1.0);
    colour = colour.lerp(DVec3::splat(0.62) * (1.0 + 0.15 * grain), paint.min(0.9));
    cover(p, f, &mut colour);
    Appearance::matt(colour)
}

/// How much of the spot is painted: a dashed axis, parking bays and zebra crossings.
fn marking(p: DVec2, length_m: f64, f: f64) -> f64 {
    let edge = 0.008 + 0.5 * f;
    let band = |x: f64, half: f64| 1.0 - smooth(half - edge, half + edge, x.abs());
    let on_street = p.x > -2.0 && p.x < length_m + 2.0;
    if !on_street || p.y.abs() > KERB_M {
        return 0.0;
    }
    let ahead = (p.x - 1.5).min(length_m - 1.5 - p.x);
    if ahead < 3.0 {
        let inside = band(ahead - 1.2, 1.3);
        let stripe = p.y.rem_euclid(1.0) - 0.5;
        return inside * band(stripe, 0.25);
    }
    let dash = band(p.y, 0.06) * band(p.x.rem_euclid(4.5) - 1.5, 1.5);
    let bay = band(p.y.abs() - (KERB_M - 2.15), 0.05) * f64::from(ahead > 4.0);
    let tick = band(p.x.rem_euclid(5.7) - 2.85, 0.05)
        * f64::from(p.y.abs() > KERB_M - 2.15 && ahead > 4.0);
    dash.max(bay).max(tick)
}

/// Manhole covers, here and there along the axis of each lane.
fn cover(p: DVec2, f: f64, colour: &mut DVec3) {
    let index = (p.x / 17.0).floor();
    let random = |n| cell(DVec2::new(index, 0.0).as_ivec2(), n);
    let centre = DVec2::new((index + 0.2 + 0.6 * random(17)) * 17.0, 2.2 * (random(18) - 0.5));
    let d = p - centre;
    let r = d.length();
    if r < 0.36 {
        let studs = (d * 16.0).rem_euclid(DVec2::ONE);
        let stud = f64::from(studs.x > 0.35 && studs.y > 0.35) * fade(0.06, f);
        let ring = f64::from(r > 0.31) * 0.6;
        *colour = DVec3::new(0.085, 0.08, 0.075) * (0.75 + 0.6 * stud - ring * 0.6);
    }
}

/// Concrete slabs, offset from row to row.
pub(crate) fn paving(spot: &Spot) -> Appearance {
    let (p, f) = (spot.position.truncate(), spot.footprint_m);
    let size = DVec2::new(0.6, 0.4);
    let row = (p.y / size.y).floor();
    let shifted = DVec2::new(p.x / size.x + 0.5 * row.rem_euclid(2.0), p.y / size.y);
    let slab = shifted.floor().as_ivec2();
    let inside = shifted.rem_euclid(DVec2::ONE);
    let to_edge = (inside.min(1.0 - inside) * size).min_element();
    let joint = (1.0 - smooth(0.004, 0.009 + 0.5 * f, to_edge)) * fade(0.3, f);
    let tone = 1.0 + 0.22 * (cell(slab, 21) - 0.5) * fade(0.6, f);
    let stains = fractal(p, 1.7, 5, f, 22);
    let grain = fractal(p, 0.03, 2, f, 23);
    let shade = tone * (1.0 + 0.3 * stains + 0.22 * grain) * (1.0 - 0.6 * joint);
    Appearance::matt(DVec3::new(0.345, 0.33, 0.305) * shade)
}

/// Granite, in stones a metre long.
pub(crate) fn kerb(spot: &Spot) -> Appearance {
    let (p, f) = (spot.position, spot.footprint_m);
    let along = p.x.rem_euclid(1.0);
    let joint = (1.0 - smooth(0.005, 0.012 + 0.5 * f, along.min(1.0 - along))) * fade(0.4, f);
    let stone = cell(DVec2::new(p.x.floor(), p.y.signum()).as_ivec2(), 24);
    let speckle = fractal(DVec2::new(p.x, p.y + p.z), 0.02, 3, f, 25);
    let shade = (0.85 + 0.3 * stone) * (1.0 + 0.6 * speckle) * (1.0 - 0.6 * joint);
    Appearance::matt(DVec3::new(0.40, 0.39, 0.38) * shade)
}

//! Parked cars: a lofted body, a glazed cabin, wheels and lamps.

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Class;
use super::model::{Model, Place};
use super::style::pick;
use crate::geometry::Shape;
use crate::look::Material;

/// A cross-section of the body: position along the car, half width, bottom and top, metres.
type Station = [f64; 4];

const BODY: [Station; 8] = [
    [-2.06, 0.66, 0.42, 0.60],
    [-1.98, 0.80, 0.27, 0.88],
    [-1.75, 0.86, 0.22, 0.93],
    [-0.60, 0.89, 0.19, 0.91],
    [0.85, 0.89, 0.19, 0.88],
    [1.60, 0.86, 0.21, 0.76],
    [1.98, 0.76, 0.26, 0.64],
    [2.10, 0.58, 0.38, 0.54],
];

/// Cabins: rear base, rear roof, front roof and windscreen base along the car, and the
/// roof's height.
const CABINS: [[f64; 5]; 3] = [
    [-1.95, -1.45, 0.20, 1.02, 1.47],
    [-1.72, -0.95, 0.15, 0.95, 1.41],
    [-2.00, -1.85, 0.35, 1.15, 1.72],
];

/// Parks a car; `place` is at its middle on the ground, `along` its driving direction.
pub(crate) fn park(model: &mut Model, place: &Place, rng: &mut ChaCha8Rng) {
    let colour = pick(
        rng,
        &[
            [0.02, 0.02, 0.025],
            [0.60, 0.61, 0.62],
            [0.30, 0.31, 0.33],
            [0.09, 0.10, 0.11],
            [0.35, 0.02, 0.02],
            [0.03, 0.08, 0.25],
            [0.05, 0.16, 0.12],
            [0.50, 0.45, 0.36],
        ],
    );
    let paint = model.surface(Class::Car, Material::CarPaint { colour });
    let glass = model.surface(Class::Car, Material::CarGlass);
    let rubber = model.surface(Class::Car, Material::Rubber);
    body(model, place, paint);
    cabin(model, place, CABINS[rng.random_range(0..CABINS.len())], paint, glass);
    wheels(model, place, rubber);
    lamps(model, place, rubber);
}

fn body(model: &mut Model, place: &Place, paint: u32) {
    let corner = |s: &Station, side: f64, top: bool| {
        place.at(s[0], side * s[1], if top { s[3] } else { s[2] })
    };
    for pair in BODY.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        for side in [-1.0, 1.0] {
            // Sides bulge at two fifths of their height.
            let middle =
                |s: &Station| place.at(s[0], side * (s[1] + 0.035), s[2] + 0.45 * (s[3] - s[2]));
            quad(
                model,
                [corner(a, side, false), corner(b, side, false), middle(b), middle(a)],
                paint,
            );
            quad(
                model,
                [middle(a), middle(b), corner(b, side, true), corner(a, side, true)],
                paint,
            );
        }
        let top = [
            corner(a, -1.0, true),
            corner(b, -1.0, true),
            corner(b, 1.0, true),
            corner(a, 1.0, true),
        ];
        quad(model, top, paint);
        let bottom = [
            corner(a, -1.0, false),
            corner(b, -1.0, false),
            corner(b, 1.0, false),
            corner(a, 1.0, false),
        ];
        quad(model, bottom, paint);
    }
    for end in [&BODY[0], &BODY[BODY.len() - 1]] {
        let face = [
            corner(end, -1.0, false),
            corner(end, 1.0, false),
            corner(end, 1.0, true),
            corner(end, -1.0, true),
        ];
        quad(model, face, paint);
    }
}

fn cabin(model: &mut Model, place: &Place, cabin: [f64; 5], paint: u32, glass: u32) {
    let [rear, rear_roof, front_roof, front, roof] = cabin;
    let belt = |along: f64, side: f64| place.at(along, side * 0.83, 0.87);
    let top = |along: f64, side: f64| place.at(along, side * 0.61, roof);
    let crown = |along: f64| place.at(along, 0.0, roof + 0.05);
    for side in [-1.0, 1.0] {
        quad(
            model,
            [belt(rear, side), belt(front, side), top(front_roof, side), top(rear_roof, side)],
            glass,
        );
        quad(
            model,
            [top(rear_roof, side), top(front_roof, side), crown(front_roof), crown(rear_roof)],
            paint,
        );
        // Pillars and the roof rail lie a little outside the glass.
        let proud = place.vector(0.0, side * 0.012, 0.0);
        let middle = 0.5 * (rear_roof + front_roof);
        for (low, high, width) in [
            (rear, rear_roof, 0.22),
            (middle - 0.05, middle, 0.10),
            (front - 0.1, front_roof - 0.1, 0.1),
        ] {
            let corner = belt(low, side) + proud;
            let shape = Shape::Sheet {
                corner,
                u: place.along * width,
                v: top(high, side) + proud - corner,
            };
            model.push(shape, paint);
        }
        let corner = top(rear_roof, side) + proud - DVec3::Z * 0.07;
        let u = place.along * (front_roof - rear_roof);
        model.push(Shape::Sheet { corner, u, v: DVec3::Z * 0.07 }, paint);
        // A mirror.
        let radii = place.vector(0.06, 0.1, 0.07).abs();
        let centre = place.at(front - 0.25, side * 0.98, 0.98);
        model.push(Shape::Ellipsoid { centre, radii }, paint);
    }
    for (low, high) in [(rear, rear_roof), (front, front_roof)] {
        quad(model, [belt(low, -1.0), belt(low, 1.0), top(high, 1.0), top(high, -1.0)], glass);
        model.push(Shape::triangle(top(high, -1.0), top(high, 1.0), crown(high)), paint);
    }
}

fn wheels(model: &mut Model, place: &Place, rubber: u32) {
    let alloy =
        model.surface(Class::Car, Material::Paintwork { colour: DVec3::new(0.36, 0.37, 0.39) });
    for along in [-1.28, 1.32] {
        for side in [-1.0, 1.0] {
            let base = place.at(along, side * 0.70, 0.31);
            let axis = place.vector(0.0, side * 0.215, 0.0);
            let shape = Shape::Tube { base, axis, base_radius: 0.31, top_radius: 0.31 };
            model.push(shape, rubber);
            let normal = axis.normalize_or(DVec3::Y);
            let centre = base + axis + normal * 0.004;
            model.push(Shape::Disc { centre, normal, radius: 0.205 }, alloy);
            // The arch: a darker, wider disc just behind the tyre's face.
            let centre = base + axis * 0.93;
            model.push(Shape::Disc { centre, normal, radius: 0.36 }, rubber);
        }
    }
}

fn lamps(model: &mut Model, place: &Place, rubber: u32) {
    let lamp = |model: &mut Model, colour| model.surface(Class::Car, Material::CarPaint { colour });
    let head = lamp(model, DVec3::new(0.75, 0.77, 0.8));
    let tail = lamp(model, DVec3::new(0.42, 0.015, 0.01));
    let plate =
        model.surface(Class::Car, Material::Paintwork { colour: DVec3::new(0.72, 0.72, 0.68) });
    for side in [-1.0, 1.0] {
        let radii = place.vector(0.13, 0.17, 0.07).abs();
        let centre = place.at(1.95, side * 0.60, 0.585);
        model.push(Shape::Ellipsoid { centre, radii }, head);
        let radii = place.vector(0.07, 0.11, 0.13).abs();
        model.push(Shape::Ellipsoid { centre: place.at(-1.98, side * 0.69, 0.74), radii }, tail);
    }
    for (along, up) in [(2.105, 0.40), (-2.065, 0.50)] {
        let low = [along - 0.012, -0.26, up];
        model.push(place.block(low, [along + 0.012, 0.26, up + 0.11]), plate);
    }
    model.push(place.block([2.02, -0.45, 0.27], [2.1, 0.45, 0.38]), rubber);
}

/// Two triangles; the corners need not lie in a plane.
fn quad(model: &mut Model, c: [DVec3; 4], surface: u32) {
    model.push(Shape::triangle(c[0], c[1], c[2]), surface);
    model.push(Shape::triangle(c[0], c[2], c[3]), surface);
}

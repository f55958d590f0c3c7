//! Normals of surfaces that are known.

use glam::{DVec3, Vec3};

use super::normals;

const SPACING_M: f32 = 0.05;
/// From a point over the mean of its cube to the farthest that counts.
const REACH_M: f64 = 0.6;

/// Places 0 to 1 that fill a square evenly without a grid, and a third number.
fn sequence(i: u32) -> [f64; 3] {
    [0.754_878, 0.569_84, 0.618_034].map(|step| ((f64::from(i) + 0.5) * step).fract())
}

/// A square of `count` points about a spacing apart, through the origin, with the normal n,
/// off its plane by up to `noise_m`.
fn square(n: DVec3, count: u32, noise_m: f64) -> Vec<[f32; 3]> {
    let (u, v) = n.any_orthonormal_pair();
    let side = f64::from(SPACING_M) * f64::from(count).sqrt();
    (0..count)
        .map(|i| {
            let [s, t, w] = sequence(i);
            let p = (u * (s - 0.5) + v * (t - 0.5)) * side + n * (2.0 * w - 1.0) * noise_m;
            p.as_vec3().to_array()
        })
        .collect()
}

/// Whether a point lies inside the square by more than the reach of an estimate.
fn inside(point: [f32; 3], n: DVec3, count: u32) -> bool {
    let (u, v) = n.any_orthonormal_pair();
    let p = Vec3::from_array(point).as_dvec3();
    let half_side = 0.5 * f64::from(SPACING_M) * f64::from(count).sqrt();
    p.dot(u).abs().max(p.dot(v).abs()) < half_side - REACH_M
}

fn angle(normal: [f32; 3], wanted: DVec3) -> f64 {
    let normal = Vec3::from_array(normal).as_dvec3();
    assert!((normal.length() - 1.0).abs() < 1e-6, "{normal} is no unit vector");
    normal.cross(wanted).length().asin().to_degrees()
}

#[test]
fn planes_are_found_in_every_direction() {
    for n in [DVec3::X, DVec3::Z, DVec3::new(0.3, -0.8, 0.52), DVec3::new(1.0, 1e-4, 0.0)] {
        let n = n.normalize();
        let points = square(n, 4000, 0.0);
        let found = normals(&points, SPACING_M);
        for (&point, &normal) in points.iter().zip(&found) {
            if normal != [0.0; 3] {
                assert!(angle(normal, n) < 0.01, "{normal:?} of {n}");
            } else {
                assert!(!inside(point, n, 4000), "none of {n} at {point:?}");
            }
        }
        let none = found.iter().filter(|&&normal| normal == [0.0; 3]).count();
        assert!(none < 80, "{none} at the border have none");
    }
}

/// Drives ±5 cm apart, points 5 cm apart.
#[test]
fn noise_turns_normals_by_degrees_only() {
    let n = DVec3::new(0.3, -0.8, 0.52).normalize();
    let found = normals(&square(n, 4000, 0.05), SPACING_M);
    let mut angles: Vec<f64> =
        found.iter().filter(|&&normal| normal != [0.0; 3]).map(|&m| angle(m, n)).collect();
    assert!(angles.len() > 3900, "{} of 4000", angles.len());
    angles.sort_by(f64::total_cmp);
    assert!(angles[angles.len() / 2] < 6.0, "{}", angles[angles.len() / 2]);
    assert!(angles[angles.len() * 99 / 100] < 20.0, "{}", angles[angles.len() * 99 / 100]);
}

/// Where two walls meet no point has the normal of the bisector.
#[test]
fn a_corner_has_the_normals_of_its_walls_or_none() {
    let n = DVec3::new(0.6, 0.8, 0.0);
    let m = DVec3::new(-0.8, 0.6, 0.0);
    let half = |n: DVec3, keep: DVec3| {
        let points = square(n, 4000, 0.0);
        points.into_iter().filter(move |&p| Vec3::from_array(p).as_dvec3().dot(keep) >= 0.0)
    };
    let points: Vec<[f32; 3]> = half(n, m).chain(half(m, n)).collect();
    let found = normals(&points, SPACING_M);
    let (mut none, mut off) = (0, 0);
    for (point, normal) in points.iter().zip(found) {
        let p = Vec3::from_array(*point).as_dvec3();
        if normal == [0.0; 3] {
            if !inside(*point, n, 4000) || !inside(*point, m, 4000) {
                continue;
            }
            none += 1;
            let distance = p.dot(n).abs().max(p.dot(m).abs());
            assert!(distance < REACH_M, "none {distance} m from the edge");
        } else if angle(normal, n).min(angle(normal, m)) > 25.0 {
            off += 1;
        }
    }
    assert!(none > 50 && none < points.len() / 3, "{none} without a normal");
    assert!(off < points.len() / 100, "{off} of {} are off", points.len());
}

#[test]
fn what_is_no_surface_has_no_normal() {
    let coincident = vec![[1.0f32, 2.0, 3.0]; 1000];
    let collinear: Vec<[f32; 3]> = (0..1000).map(|i| [i as f32 * 0.01, 0.0, 5.0]).collect();
    let four = square(DVec3::Z, 4, 0.0);
    let solid: Vec<[f32; 3]> =
        (0..4000).map(|i| sequence(i).map(|x| (x * 32.0) as f32 * SPACING_M)).collect();
    for (name, points) in [
        ("no points", Vec::new()),
        ("one point", vec![[1.0; 3]]),
        ("coincident points", coincident),
        ("collinear points", collinear),
        ("four points", four),
    ] {
        let found = normals(&points, SPACING_M);
        assert_eq!(found.len(), points.len(), "{name}");
        assert!(found.iter().all(|&normal| normal == [0.0; 3]), "{name}");
    }
    let found = normals(&solid, SPACING_M);
    let flat = found.iter().filter(|&&normal| normal != [0.0; 3]).count();
    assert!(flat < solid.len() / 20, "{flat} of a solid cube's points");
}

#[test]
fn a_spacing_that_is_none_gives_no_normals() {
    for spacing_m in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(normals(&square(DVec3::Z, 10, 0.0), spacing_m).is_empty());
    }
}

/// Five hundred points in each place give what one would, as soon.
#[test]
fn crowded_points_cost_no_more_than_few() {
    let few = square(DVec3::Z, 2000, 0.0);
    let crowd: Vec<[f32; 3]> = few.iter().cycle().take(1_000_000).copied().collect();
    let found = normals(&crowd, SPACING_M);
    assert_eq!(found.len(), crowd.len());
    assert!(found.iter().all(|&normal| angle(normal, DVec3::Z) < 0.01));
}

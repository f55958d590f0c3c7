//! The agreement of depth maps on the device against its reference, the equations behind overlaps
//! and gains against theirs, and the way to a new gain.

use super::measure::{AGREE_WGSL, Samples};
use super::overlaps::overlaps;
use super::reference::{agreement, continuity, known_surface, overlap, solved};
use super::solve::solve;
use super::{SAME, towards};
use crate::depth_map::reference::Occluders;
use crate::kernel_tests::run;
use crate::mesh::reference::NO_MESH_M;
use crate::tolerances::{DEPTH_TEST_RELATIVE, OVERLAP_LOGARITHM, SOLVED_LOGARITHM};

const KERNEL: &str = "
@group(0) @binding(0) var<storage, read> queries: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> found: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&queries) {
        let q = queries[id.x];
        let known = known_surface(q.yz, q.w);
        found[id.x] = vec4(
            known,
            select(0.0, 1.0, agrees(q.x, known)),
            select(0.0, 1.0, is_same_surface(q.x, known)),
        );
    }
}";

#[test]
fn device_and_reference_agree() {
    let mut queries = Vec::new();
    for i in 0..4000u32 {
        let t = f64::from(i);
        let z = 0.5 + 40.0 * (0.5 + 0.5 * (0.37 * t).sin());
        let mesh = if i % 7 == 0 { NO_MESH_M } else { z + 3.0 * (1.3 * t).sin() };
        let uncertainty = if i % 7 == 0 { 0.0 } else { 0.5 * (0.9 * t).cos().abs() };
        let point = if i % 5 == 0 { f64::NAN } else { z + 2.0 * (2.1 * t).cos() };
        queries.push([z, mesh, uncertainty, point].map(|x| x as f32));
    }
    let source = [AGREE_WGSL, KERNEL].concat();
    let found: Vec<[f32; 4]> =
        run(&source, &[bytemuck::cast_slice(&queries)], queries.len(), queries.len());
    let mut decided = 0;
    for (query, found) in queries.iter().zip(found) {
        let [z, mesh_m, mesh_uncertainty_m, point_m] = query.map(f64::from);
        let expected = known_surface(Occluders { mesh_m, mesh_uncertainty_m, point_m });
        let Some(known) = expected else {
            assert!(
                f64::from(found[0]) >= 0.9 * NO_MESH_M && found[2] == 0.0,
                "{query:?} {found:?}"
            );
            continue;
        };
        assert_eq!([found[0], found[1]], [known.0 as f32, known.1 as f32], "{query:?}");
        for (margin, found) in [agreement(z, known), continuity(z, known.0)].iter().zip(&found[2..])
        {
            if margin.abs() > DEPTH_TEST_RELATIVE * z {
                decided += 1;
                assert_eq!(*found == 1.0, *margin > 0.0, "{query:?} {margin}");
            }
        }
    }
    assert!(decided > 7000, "{decided}");
}

/// What seven photographs show of places that each lent, some of it wrong, dark, or not seen.
fn samples() -> Samples {
    let places_each = 40;
    let colour = |photograph: usize, place: usize| {
        let (p, q) = (photograph as f64, place as f64);
        // Of the street, photographs next to each other see the same.
        let seen = (p - (q / places_each as f64)).abs() < 2.5 && (1.3 * q + 2.1 * p).sin() > -0.7;
        let wrong = if (0.7 * q + 3.3 * p).sin() > 0.8 { 1.9 } else { 1.0 };
        let exposure = wrong * (0.4 * (2.3 * p).sin()).exp();
        let of_channel = |c: f64| {
            let true_colour = 0.3 + 0.295 * (0.9 * q + c).sin();
            (true_colour * exposure * (0.05 * (p * c).cos()).exp()) as f32
        };
        seen.then(|| [0.0, 1.0, 2.0].map(of_channel))
    };
    let of_photograph = |p| (0..7 * places_each).map(|q| colour(p, q)).collect();
    Samples { places_each, colours: (0..7).map(of_photograph).collect() }
}

#[test]
fn overlaps_and_what_solves_them_agree_with_their_references() {
    let samples = samples();
    let found = overlaps(&samples);
    let places = |a: usize, b: usize| {
        let lent = |by: usize| by * samples.places_each..(by + 1) * samples.places_each;
        let colours = |i: usize, place: usize| samples.colours[i][place].map(|c| c.map(f64::from));
        let both = |place| Some([colours(a, place)?, colours(b, place)?]);
        lent(a).chain(lent(b)).filter_map(both).collect::<Vec<_>>()
    };
    let pairs = (1..7).flat_map(|b| (0..b).map(move |a| (a, b)));
    let expected: Vec<_> = pairs.filter_map(|(a, b)| overlap(a, b, &places(a, b))).collect();
    assert!(expected.len() > 6 && expected.len() < 21, "{}", expected.len());
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((found.a, found.b), (expected.a, expected.b));
        for (found, expected) in found.log_ratio.iter().zip(expected.log_ratio) {
            assert!((found - expected).abs() < OVERLAP_LOGARITHM, "{found} for {expected}");
        }
        let deviations = [found.variance, expected.variance].map(f64::sqrt);
        assert!((deviations[0] - deviations[1]).abs() < OVERLAP_LOGARITHM, "{deviations:?}");
    }
    for (found, expected) in solve(7, &expected).iter().zip(solved(7, &expected)) {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < SOLVED_LOGARITHM, "{found} for {expected}");
        }
    }
}

#[test]
fn a_new_gain_is_reached_without_a_jump() {
    let target = [0.3, -0.2, 0.1];
    let mut shown = [0.0; 3];
    for frame in 0.. {
        let next = towards(shown, target);
        for channel in 0..3 {
            let left = (target[channel] - shown[channel]).abs();
            assert!((next[channel] - shown[channel]).abs() <= (0.151 * left).max(SAME));
        }
        if next == target {
            break;
        }
        assert!(frame < 60, "{next:?}");
        shown = next;
    }
    assert_eq!(towards(target, target), target);
}

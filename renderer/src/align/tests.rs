//! The step of alignment on the device against its reference, and how it is shared.

use glam::DVec2;

use super::level::Level;
use super::reference::lucas_kanade;
use super::sheet::{Sheet, regions};
use super::{LUCAS_KANADE_WGSL, Shares};
use crate::infer::Grid;
use crate::kernel_tests::{gpu, run};
use crate::tolerances::{ALIGNMENT_CELLS, FOUND_CELLS, SHARE_STEP, STILL_CELLS};

const KERNEL: &str = "
@group(0) @binding(0) var<storage, read> queries: array<array<vec4<f32>, 2>>;
@group(0) @binding(1) var<storage, read_write> steps: array<vec2<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&queries) {
        let q = queries[id.x];
        steps[id.x] = lucas_kanade(q[0], q[1].xy);
    }
}";

/// Sums over a window of seven by seven gradients g, where the difference is -g . s and some
/// noise.
fn sums(seed: f64, strength: f64, step: DVec2, noise: f64) -> ([f64; 3], DVec2, f64) {
    let (mut ggt, mut gd, mut dd) = ([0.0; 3], DVec2::ZERO, 0.0);
    for i in 0..49 {
        let t = seed + f64::from(i);
        let g = strength * DVec2::new((1.7 * t).sin(), (2.3 * t + 0.4).cos());
        let d = noise * (5.1 * t).sin() - g.dot(step);
        ggt = [ggt[0] + g.x * g.x, ggt[1] + g.x * g.y, ggt[2] + g.y * g.y];
        gd += g * d;
        dd += d * d;
    }
    (ggt, gd, dd)
}

#[test]
fn device_and_reference_agree() {
    let cases: Vec<_> = (0..400u32)
        .map(|i| {
            let t = f64::from(i);
            let step = 1.5 * DVec2::new((0.37 * t).sin(), (0.91 * t).cos());
            sums(t, 0.2 * (t / 400.0), step, 0.05 * (0.11 * t).sin())
        })
        .collect();
    let queries: Vec<[f32; 8]> = cases
        .iter()
        .map(|&([xx, xy, yy], gd, dd)| {
            [xx, xy, yy, gd.x, gd.y, dd, 0.0, 0.0].map(|value| value as f32)
        })
        .collect();
    let source = [LUCAS_KANADE_WGSL, KERNEL].concat();
    let inputs = [bytemuck::cast_slice(&queries)];
    let found: Vec<[f32; 2]> = run(&source, &inputs, cases.len(), cases.len());
    for (&(ggt, gd, dd), found) in cases.iter().zip(found) {
        let found = DVec2::from_array(found.map(f64::from));
        let expected = lucas_kanade(ggt, gd, dd);
        assert!(found.distance(expected) < ALIGNMENT_CELLS, "{found} for {expected}");
    }
}

#[test]
fn what_is_displaced_is_found_and_noise_is_not() {
    for step in [DVec2::new(0.4, -0.3), DVec2::new(-0.7, 0.1)] {
        let (ggt, gd, dd) = sums(0.0, 0.2, step, 0.0);
        let found = lucas_kanade(ggt, gd, dd);
        assert!(found.distance(step) < FOUND_CELLS, "{found} for {step}");
    }
    let (ggt, gd, dd) = sums(0.0, 0.002, DVec2::ZERO, 0.01);
    assert!(lucas_kanade(ggt, gd, dd).length() < STILL_CELLS);
}

#[test]
fn shares_change_little_by_little() {
    // At a photograph's own place nothing of it moves.
    let at = Shares::new(&[0.0, 3.0, 6.0]).expect("two rigs");
    assert_eq!((at.nearest, at.applied), (0.0, 1.0));
    assert_eq!(Shares::new(&[1.0, 1.0]).expect("two rigs").nearest, 0.5);
    // Where the second and the third change places nothing is applied.
    assert_eq!(Shares::new(&[1.0, 3.0, 3.0]).expect("three rigs").applied, 0.0);
    assert_eq!(Shares::new(&[0.0, 0.0, 0.0]).expect("three rigs").applied, 0.0);
    assert_eq!(Shares::new(&[1.0]), None);
    let mut before = None;
    for i in 0..=1000 {
        let third = 3.0 + 0.002 * f64::from(i);
        let now = Shares::new(&[1.0, 3.0, third]).expect("three rigs").applied;
        let last = before.replace(now).unwrap_or(0.0);
        assert!((now - last).abs() < SHARE_STEP && now >= last);
    }
    assert_eq!(before, Some(1.0));
}

#[test]
fn bytes_are_known_before_they_are_taken() {
    let grid = Grid::alone(glam::UVec2::new(333, 222), 8192).expect("a grid");
    let grids = super::levels(grid);
    let regions = regions(&grids);
    assert_eq!(Level::new(gpu(), grid, regions[0]).bytes(), Level::bytes_for(grid));
    assert_eq!(Sheet::new(gpu(), &grids).bytes(), Sheet::bytes_for(&grids));
    // None lies upon another.
    for (i, a) in regions.iter().enumerate() {
        for b in &regions[..i] {
            let beside = (a.origin + a.size).cmple(b.origin) | (b.origin + b.size).cmple(a.origin);
            assert!(beside.any(), "{a:?} {b:?}");
        }
    }
}

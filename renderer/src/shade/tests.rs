//! The weights on the device, and the curve of colours, against their reference.

use flaneur_scene::srgb_from_linear;
use glam::DVec3;

use super::reference::{edge_weight, feather_weight, mask_weight, park_weight, pixels_off};
use crate::kernel_tests::run;
use crate::tolerances::{DECODED_255, WEIGHT_ABSOLUTE, WEIGHT_RELATIVE};

const KERNEL: &str = "
@group(0) @binding(0) var<storage, read> queries: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> weights: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&queries) {
        let q = queries[id.x];
        weights[id.x] = vec4(park_weight(q.x, q.y, q.z), feather_weight(q.w), edge_weight(q.w), mask_weight(q.w));
    }
}";

#[test]
fn device_and_reference_agree() {
    let place = DVec3::new(3.0, 7.0, 1.0);
    let n = DVec3::new(-0.6, -0.8, 0.0);
    let mut cases = Vec::new();
    for i in 0..500u32 {
        let t = f64::from(i);
        // All around the place, also behind its plane and at its own position.
        let photograph = place + DVec3::new(t.sin(), t.cos(), 0.3 * (2.0 * t).sin()) * 0.04 * t;
        // From the photograph's own centre outwards.
        let eye = photograph + DVec3::new(1.0, -2.0, 0.5) * 0.001 * t * t;
        cases.push((photograph, eye, t / 499.0));
    }
    // At the place itself there is no direction.
    cases.retain(|(photograph, ..)| photograph.distance(place) > 1e-3);
    let queries: Vec<[f32; 4]> = cases
        .iter()
        .map(|(photograph, eye, share)| {
            let d = photograph - place;
            let cosine = n.dot(d.normalize());
            let eye_2 = (eye - photograph).length_squared();
            [cosine, d.length_squared(), eye_2, *share].map(|x| x as f32)
        })
        .collect();
    let found: Vec<[f32; 4]> = run(
        &[super::BLEND_WGSL, KERNEL].concat(),
        &[bytemuck::cast_slice(&queries)],
        queries.len(),
        queries.len(),
    );
    for ((photograph, eye, share), found) in cases.into_iter().zip(found) {
        let expected = [
            park_weight(n, place, photograph, (eye - photograph).length_squared()),
            feather_weight(share),
            edge_weight(share),
            mask_weight(share),
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            let found = f64::from(found);
            let allowed = WEIGHT_RELATIVE * expected + WEIGHT_ABSOLUTE;
            assert!((found - expected).abs() <= allowed, "{found} for {expected} at {share}");
        }
    }
}

/// Against a place that is moved along the ray of the eye, and projected again.
#[test]
fn a_place_of_unsure_depth_is_off_along_the_ray() {
    let photograph = DVec3::new(0.4, -0.2, -3.0);
    let (focal, share) = (700.0, 1e-6);
    for i in 0..50 {
        let t = f64::from(i);
        let place = DVec3::new(4.0 * t.sin(), 3.0 * (2.0 * t).cos(), 5.0 + t);
        let pixel = |place: DVec3| {
            let position = place - photograph;
            focal * position.truncate() / position.z
        };
        let moved = pixel(place * (1.0 + share)).distance(pixel(place));
        let found = pixels_off(share, place, place - photograph, focal);
        assert!((found - moved).abs() < 1e-3 * moved + 1e-12, "{found} for {moved} at {place}");
        // Where the eye is at the photograph, it is where it is whatever its depth.
        assert!(pixels_off(share, place, place, focal) < 1e-12);
    }
}

const DECODE: &str = "
@group(0) @binding(0) var<storage, read> encoded: array<f32>;
@group(0) @binding(1) var<storage, read_write> linear: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&encoded) {
        linear[id.x] = linear_from_srgb(vec3(encoded[id.x])).x;
    }
}";

#[test]
fn colours_are_decoded() {
    // Every byte, and what filtering makes between two.
    let encoded: Vec<f32> = (0..=255 * 8).map(|i| i as f32 / (255.0 * 8.0)).collect();
    let linear: Vec<f32> = run(
        &[crate::SRGB_WGSL, DECODE].concat(),
        &[bytemuck::cast_slice(&encoded)],
        encoded.len(),
        encoded.len(),
    );
    for (encoded, linear) in encoded.into_iter().zip(linear) {
        let off = (srgb_from_linear(linear.into()) - f64::from(encoded)).abs() * 255.0;
        assert!(off <= DECODED_255, "{encoded} is off by {off}");
    }
}

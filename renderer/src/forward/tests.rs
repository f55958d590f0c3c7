//! The homography on the device against its reference, and that against projection.

use flaneur_scene::{Intrinsics, Lens, PosedCamera, world_from_rig};
use glam::{DMat3, DVec2, DVec3, UVec2};

use super::reference::{Found, Pinhole, by_homography, by_projection, homography};
use crate::camera::gpu_data::Camera;
use crate::kernel_tests::run;
use crate::tolerances::{
    EPIPOLE_PX, HOMOGRAPHY_DEPTH_RELATIVE, HOMOGRAPHY_F64, HOMOGRAPHY_PX, REFERENCE_M,
    REFERENCE_PX, SINGULAR,
};
use crate::{camera, pinhole};

const KERNEL: &str = "
struct Query {
    camera: Camera,
    right: vec3<f32>,
    pixel_x: f32,
    down: vec3<f32>,
    pixel_y: f32,
    forward: vec3<f32>,
    q_x: f32,
    centre: vec3<f32>,
    q_y: f32,
    p: vec3<f32>,
    padding_0: f32,
    n: vec3<f32>,
    padding_1: f32,
}

@group(0) @binding(0) var<storage, read> queries: array<Query>;
@group(0) @binding(1) var<storage, read_write> found: array<vec4<f32>>;

// What the homography gives, and what projecting the place gives.
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&queries) {
        let query = queries[id.x];
        let turn = transpose(mat3x3(query.right, query.down, query.forward));
        let pixel = vec2(query.pixel_x, query.pixel_y);
        let q = vec2(query.q_x, query.q_y);
        let plane = plane_through(query.p, query.n);
        let h = homography(query.camera, pixel, plane, turn, turn * -query.centre);
        found[2u * id.x] = h * vec3(q, 1.0);
        let ray = ray_through(query.camera, normalised(query.camera, pixel + q));
        let depth = plane_depth(vec4(query.n, dot(query.n, query.p)), ray);
        found[2u * id.x + 1u] = vec4(turn * (on_ray(ray, depth) - query.centre), depth);
    }
}";

#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Query {
    camera: Camera,
    right: [f32; 3],
    pixel_x: f32,
    down: [f32; 3],
    pixel_y: f32,
    forward: [f32; 3],
    q_x: f32,
    centre: [f32; 3],
    q_y: f32,
    p: [f32; 3],
    padding_0: f32,
    n: [f32; 3],
    padding_1: f32,
}

/// A pixel of a sprite, and what is known of its plane.
#[derive(Clone, Copy, Debug)]
struct Case {
    view: PosedCamera,
    photograph: PosedCamera,
    p: DVec3,
    n: DVec3,
    /// The sprite's own pixel, and from there to the one that is looked up.
    pixel: DVec2,
    q: DVec2,
}

const FOCAL: DVec2 = DVec2::new(1100.0, 1080.0);

/// Off-centre, unequal focals.
fn lens(focal: DVec2) -> Lens {
    let intrinsics = Intrinsics { fx: focal.x, fy: focal.y, cx: 530.0, cy: 249.0 };
    Lens::pinhole(UVec2::new(1024, 512), intrinsics)
}

fn posed(centre: DVec3, heading: f64, pitch: f64, focal: DVec2) -> PosedCamera {
    let rig = world_from_rig(heading, pitch, 0.1).transpose();
    let cam_from_rig = DMat3::from_cols_array(&[1., 0., 0., 0., 0., 1., 0., -1., 0.]);
    PosedCamera { centre, cam_from_world: cam_from_rig * rig, lens: lens(focal) }
}

fn ideal(camera: &PosedCamera) -> Pinhole {
    let i = camera.lens.intrinsics;
    let k = DMat3::from_cols(
        DVec3::new(i.fx, 0.0, 0.0),
        DVec3::new(0.0, i.fy, 0.0),
        DVec3::new(i.cx, i.cy, 1.0),
    );
    Pinhole { m: k * camera.cam_from_world, centre: camera.centre }
}

/// Low-discrepancy: every combination of what they choose occurs.
fn sequence(i: u32, step: f64) -> f64 {
    ((f64::from(i) + 0.5) * step).fract()
}

/// Unit, at `cosine` to the direction `toward`, the rest of it any way.
fn inclined(toward: DVec3, cosine: f64, turn: f64) -> DVec3 {
    let (a, b) = toward.normalize().any_orthonormal_pair();
    let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
    -toward.normalize() * cosine + (a * cos + b * sin) * (1.0 - cosine * cosine).sqrt()
}

/// Places up to 80 m before a view, planes inclined by up to 84°, photographs up to 12 m aside.
fn ordinary(origin: DVec3) -> Vec<Case> {
    (0..4000)
        .map(|i| {
            let view = posed(origin, 0.7, 0.05, DVec2::new(900.0, 910.0));
            let aside = DVec3::new(sequence(i, 0.618_034), sequence(i, 0.754_878), 0.5) - 0.5;
            let photograph = posed(origin + aside * 24.0, 0.7 + 0.6 * aside.y, 0.0, FOCAL);
            let pixel = DVec2::new(1024.0, 512.0)
                * DVec2::new(sequence(i, 0.569_84), sequence(i, 0.324_718));
            let depth = 2.0 + 78.0 * sequence(i, 0.438_579).powi(2);
            let cosine = 1.0 - 0.9 * sequence(i, 0.281_984);
            on_pixel(view, photograph, pixel, depth, cosine, i)
        })
        .collect()
}

/// A point seen at about `pixel`, and a pixel as far from it as sprites reach.
fn on_pixel(
    view: PosedCamera,
    photograph: PosedCamera,
    pixel: DVec2,
    depth: f64,
    cosine: f64,
    i: u32,
) -> Case {
    let ray = view.lens.intrinsics.normalised_from_pixel(pixel).extend(1.0);
    let toward = view.cam_from_world.transpose() * ray;
    let aside = DVec2::new(sequence(i, 0.852_63), sequence(i, 0.145_9)) * 384.0 - 192.0;
    Case {
        view,
        photograph,
        p: view.centre + toward * depth,
        n: inclined(toward, cosine, sequence(i, 0.911_2)),
        pixel: pixel.floor() + 0.5,
        q: aside.round(),
    }
}

/// What the device finds by homography and by projection, as places in photograph and view; of
/// `None` it says that there is none.
fn on_device(cases: &[Case]) -> Vec<[Option<Found>; 2]> {
    let queries: Vec<Query> = cases
        .iter()
        .map(|case| {
            let pinhole = pinhole::Pinhole::for_view(&case.view.lens, 4096, 1 << 20);
            let axes = case.photograph.cam_from_world.transpose();
            let f32s = |v: DVec3| v.as_vec3().to_array();
            Query {
                camera: Camera::new(&case.view, &pinhole.expect("a pinhole")),
                right: f32s(axes.x_axis),
                pixel_x: case.pixel.x as f32,
                down: f32s(axes.y_axis),
                pixel_y: case.pixel.y as f32,
                forward: f32s(axes.z_axis),
                q_x: case.q.x as f32,
                centre: f32s(case.photograph.centre - case.view.centre),
                q_y: case.q.y as f32,
                p: f32s(case.p - case.view.centre),
                padding_0: 0.0,
                n: f32s(case.n),
                padding_1: 0.0,
            }
        })
        .collect();
    let source = [camera::WGSL, super::HOMOGRAPHY_WGSL, KERNEL].concat();
    let count = queries.len();
    let found: Vec<[f32; 4]> = run(&source, &[bytemuck::cast_slice(&queries)], count, 2 * count);
    let place = |[x, y, z]: [f64; 3], view_depth| {
        (view_depth > 0.0).then_some(Found { place: DVec3::new(x, y, z), view_depth })
    };
    found
        .chunks_exact(2)
        .map(|pair| {
            let [[x, y, z, inverse], projected] = [pair[0], pair[1]].map(|v| v.map(f64::from));
            let [px, py, pz, depth] = projected;
            let scaled = [x, y, z].map(|v| v / inverse);
            [place(scaled, inverse), place([px, py, pz], depth)]
        })
        .collect()
}

fn truth(case: &Case) -> Found {
    let q = (case.pixel + case.q).extend(1.0);
    by_projection(&ideal(&case.view), &ideal(&case.photograph), case.p, case.n, q)
}

/// Pixel of the photograph of a place in its frame.
fn in_photograph(case: &Case, found: &Found) -> DVec2 {
    let m = found.place.truncate() / found.place.z;
    case.photograph.lens.intrinsics.pixel_from_normalised(m)
}

/// Whether the splat pass and the photograph could show it: near the point's depth, before the
/// photograph, in a picture up to 120° wide.
fn is_shown(case: &Case, truth: &Found) -> bool {
    let p = case.view.cam_from_world(case.p).z;
    let i = case.photograph.lens.intrinsics;
    let m = i.normalised_from_pixel(truth.place.truncate() / truth.place.z);
    (0.8 * p..1.25 * p).contains(&truth.view_depth) && truth.place.z > 0.5 && m.length() < 1.7
}

/// Compares, and gives how many cases are shown and the largest errors, in pixels, of the
/// homography and of projection. `allowed` for each case.
fn compare(name: &str, cases: &[Case], allowed: impl Fn(&Case) -> f64) -> usize {
    let (mut shown, mut worst) = (0, [0.0f64; 2]);
    for (case, found) in cases.iter().zip(on_device(cases)) {
        let truth = truth(case);
        if !is_shown(case, &truth) {
            continue;
        }
        shown += 1;
        let expected = truth.place.truncate() / truth.place.z;
        let errors = found.map(|found| {
            found.map_or(f64::INFINITY, |found| in_photograph(case, &found).distance(expected))
        });
        let [by_homography, _] = errors;
        let allowed = allowed(case);
        assert!(
            by_homography <= allowed,
            "{name}: {by_homography} px, {allowed} allowed, {case:?}"
        );
        let depth = found[0].map_or(0.0, |found| found.place.z);
        let depth_error = (depth / truth.place.z - 1.0).abs();
        assert!(
            depth_error < HOMOGRAPHY_DEPTH_RELATIVE * allowed / HOMOGRAPHY_PX,
            "{name}: depth {depth} of {truth:?}"
        );
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
    }
    let [homography, projection] = worst;
    println!("{name}: {shown} shown, homography {homography:.6} px, projection {projection:.6} px");
    shown
}

#[test]
fn the_reference_is_projection_onto_the_plane() {
    let mut worst = DVec3::ZERO;
    for case in ordinary(DVec3::new(651_187.0, 6_861_353.0, 42.0)) {
        let (view, photograph) = (ideal(&case.view), ideal(&case.photograph));
        let q = (case.pixel + case.q).extend(1.0);
        let direct = by_projection(&view, &photograph, case.p, case.n, q);
        if !is_shown(&case, &direct) {
            continue;
        }
        // Neither length nor sign of N counts.
        for scale in [1.0, -1.0, 1e-3, -250.0] {
            let found = by_homography(&view, &photograph, case.p, case.n * scale, q);
            let pixel = |found: &Found| found.place.truncate() / found.place.z;
            let off_px = pixel(&found).distance(pixel(&direct));
            let off_m = (found.place.z - direct.place.z).abs();
            let off_view_m = (found.view_depth - direct.view_depth).abs();
            assert!(
                off_px < REFERENCE_PX && off_m < REFERENCE_M && off_view_m < REFERENCE_M,
                "{off_px} {off_m} {case:?}"
            );
            worst = worst.max(DVec3::new(off_px, off_m, off_view_m));
        }
    }
    println!("worst: {} px, {} m, {} m of the view", worst.x, worst.y, worst.z);
}

#[test]
fn ordinary_planes() {
    let shown = compare("ordinary", &ordinary(DVec3::ZERO), |_| HOMOGRAPHY_PX);
    assert!(shown > 1000, "{shown}");
}

#[test]
fn far_coordinates() {
    for origin in [DVec3::new(651_187.3, 6_861_353.6, 42.8), DVec3::new(1e8, -1e8, 3000.0)] {
        let shown = compare("far", &ordinary(origin), |_| HOMOGRAPHY_PX);
        assert!(shown > 1000, "{shown}");
    }
}

/// Errors grow as one over the cosine, however they are computed; nothing else may happen.
#[test]
fn grazing_planes() {
    for exponent in 1..=5 {
        let cosine = 10f64.powi(-exponent);
        let cases: Vec<Case> = ordinary(DVec3::ZERO)
            .into_iter()
            .zip(0..)
            .map(|(case, i)| {
                let toward = case.p - case.view.centre;
                // Along the horizon of the plane, where it stays in sight.
                Case { n: inclined(toward, cosine, sequence(i, 0.911_2)), q: DVec2::ZERO, ..case }
            })
            .map(|case| Case { pixel: exact_pixel(&case), ..case })
            .collect();
        let allowed = HOMOGRAPHY_PX * (0.1 / cosine).max(1.0);
        let shown = compare(&format!("cosine 1e-{exponent}"), &cases, |_| allowed);
        assert!(shown > 1000, "{shown}");
    }
}

/// Where the view sees the point itself.
fn exact_pixel(case: &Case) -> DVec2 {
    let p = case.view.cam_from_world(case.p);
    case.view.lens.intrinsics.pixel_from_normalised(p.truncate() / p.z)
}

#[test]
fn planes_seen_edge_on_show_nothing() {
    let cases: Vec<Case> = ordinary(DVec3::ZERO)
        .into_iter()
        .zip(0..)
        .map(|(case, i)| {
            let n = inclined(case.p - case.view.centre, 0.0, sequence(i, 0.911_2));
            Case { n: n * if i % 2 == 0 { 0.0 } else { 1.0 }, ..case }
        })
        .collect();
    for [found, _] in on_device(&cases) {
        // In f32 some planes are not quite edge-on.
        assert!(found.is_none_or(|found| found.place.is_finite()), "{found:?}");
    }
    let none = on_device(&cases).iter().step_by(2).filter(|[found, _]| found.is_some()).count();
    assert_eq!(none, 0, "planes without normal");
}

/// H is singular: all of the plane is one line of the photograph.
#[test]
fn the_photographs_centre_on_the_plane() {
    let cases: Vec<Case> = ordinary(DVec3::ZERO)
        .into_iter()
        .map(|case| {
            let (to_photograph, to_eye) =
                (case.photograph.centre - case.p, case.view.centre - case.p);
            let n = (to_eye
                - to_photograph * to_eye.dot(to_photograph) / to_photograph.length_squared())
            .normalize();
            Case { n, ..case }
        })
        .filter(|case| case.n.dot((case.view.centre - case.p).normalize()) > 0.1)
        .collect();
    for case in &cases {
        let (h, _) = homography(&ideal(&case.view), &ideal(&case.photograph), case.p, case.n);
        let scale = h.x_axis.length() * h.y_axis.length() * h.z_axis.length();
        assert!(h.determinant().abs() < SINGULAR * scale, "{case:?}");
    }
    let shown = compare("centre on the plane", &cases, |_| HOMOGRAPHY_PX);
    assert!(shown > 300, "{shown}");
}

/// H is a rotation, whatever the plane.
#[test]
fn no_baseline() {
    let cases: Vec<Case> = ordinary(DVec3::ZERO)
        .into_iter()
        .map(|case| {
            let photograph = PosedCamera { centre: case.view.centre, ..case.photograph };
            Case { photograph, ..case }
        })
        .collect();
    let shown = compare("no baseline", &cases, |_| HOMOGRAPHY_PX);
    assert!(shown > 1000, "{shown}");
    for case in &cases {
        let (view, photograph) = (ideal(&case.view), ideal(&case.photograph));
        let (h, _) = homography(&view, &photograph, case.p, case.n);
        let rotation = photograph.m * view.m.inverse() * case.n.dot(case.p - view.centre);
        assert!(
            (h - rotation).abs().to_cols_array().iter().all(|&x| x < HOMOGRAPHY_F64),
            "{case:?}"
        );
    }
}

#[test]
fn places_behind_the_photograph() {
    let cases: Vec<Case> = ordinary(DVec3::ZERO)
        .into_iter()
        .map(|case| {
            let photograph =
                posed(case.p + (case.p - case.view.centre).normalize() * 3.0, 0.7, 0.05, FOCAL);
            Case { photograph, ..case }
        })
        .collect();
    let mut behind = 0;
    for (case, [found, _]) in cases.iter().zip(on_device(&cases)) {
        let truth = truth(case);
        if truth.view_depth > 0.0 && truth.view_depth < 100.0 && truth.place.z < -0.1 {
            behind += 1;
            assert!(found.is_some_and(|found| found.place.z < 0.0), "{found:?} for {truth:?}");
        }
    }
    assert!(behind > 1000, "{behind}");
}

/// The photograph sees the eye in its first column, and places just before it.
#[test]
fn the_epipole_on_the_border() {
    let border = lens(FOCAL).intrinsics.normalised_from_pixel(DVec2::new(0.0, 200.0)).extend(1.0);
    let cases: Vec<Case> = ordinary(DVec3::ZERO)
        .into_iter()
        .zip(0..)
        .map(|(case, i)| {
            let to_eye = case.photograph.cam_from_world.transpose() * border;
            let distance = 3.0 + 9.0 * sequence(i, 0.618_034);
            let centre = case.view.centre - to_eye.normalize() * distance;
            let photograph = PosedCamera { centre, ..case.photograph };
            // From the line through both centres to some degrees beside it.
            let aside = DVec2::new(sequence(i, 0.754_878), sequence(i, 0.569_84)) - 0.5;
            let (a, b) = to_eye.normalize().any_orthonormal_pair();
            let toward = to_eye.normalize() + (a * aside.x + b * aside.y) * 0.2 * f64::from(i % 5);
            let p = case.view.centre + toward * (1.0 + 20.0 * sequence(i, 0.438_579));
            let n = inclined(toward, 1.0 - 0.9 * sequence(i, 0.281_984), sequence(i, 0.911_2));
            let case = Case { photograph, p, n, ..case };
            Case { pixel: exact_pixel(&case).floor() + 0.5, ..case }
        })
        .collect();
    let epipole =
        ideal(&cases[0].photograph).m * (cases[0].view.centre - cases[0].photograph.centre);
    assert!((epipole.truncate() / epipole.z).x.abs() < EPIPOLE_PX);
    let shown = compare("epipole on the border", &cases, |_| HOMOGRAPHY_PX);
    assert!(shown > 300, "{shown}");
}

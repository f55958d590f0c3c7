//! Frames of the device against frames of the reference.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use flaneur_scene::{Distortion, Intrinsics, Lens, PosedCamera, SceneUpdate, View};
use glam::{DVec2, DVec3, UVec2};

use super::difference::STEP_M;
use super::{Pixel, ReferenceFrame, Scene};
use crate::kernel_tests::{gpu, positions};
use crate::tolerances::{DEPTH_M, FRAME_ALIKE_SHARE, FRAME_MINIFIED_255, JITTER_M};
use crate::{Frame, Mode, Renderer, Settings, SplatNormals, Surface, Texturing};

#[expect(
    clippy::duplicate_mod,
    reason = "the tolerances of the tests from outside are this crate's"
)]
#[path = "../../tests/common/mod.rs"]
mod common;

mod alignment;
mod completion;
mod everything;
mod gains;
mod inference;
mod levels;
mod near_first;

use common::{Street, camera, image_update, keep, mesh_update, points_update, with_lens};

const SIZE: UVec2 = UVec2::new(240, 180);
const PHOTO: UVec2 = UVec2::new(400, 300);
/// So coarse that its full level alone is looked up, also in views from afar and of what is close to it.
const COARSE_PHOTO: UVec2 = UVec2::new(56, 42);

/// Walls and ground as mesh that is uncertain by 5 cm, coloured points on the pole and on the
/// wall, and photographs of two rigs, one of them with two cameras.
fn street(origin: DVec3) -> Vec<SceneUpdate> {
    street_taken(origin, PHOTO)
}

/// The same with photographs of another size, which see the same.
fn street_taken(origin: DVec3, photo: UVec2) -> Vec<SceneUpdate> {
    let street = Street::with_pole(origin);
    let mut points = street.points(&[1], 0.03);
    points.positions.extend(street.points(&[0], 0.12).positions);
    points.colours = (0..points.positions.len())
        .map(|i| [(i % 251) as u8, (i % 13) as u8, if i % 3 == 0 { 0 } else { 200 }])
        .collect();
    let mut updates = photographs(&street, photo, Distortion::None);
    updates.push(mesh_update(street.mesh(&[0, 2, 3], 0.05)));
    updates.push(points_update(points));
    updates
}

fn photographs(street: &Street, photo: UVec2, distortion: Distortion) -> Vec<SceneUpdate> {
    let photograph = |id: &str, at, heading| {
        let camera = camera(street.origin, at, heading, 5.0, 70.0, photo);
        let lens = Lens { distortion, ..camera.lens };
        image_update(street.photograph(id, with_lens(camera, lens)))
    };
    vec![
        photograph("a/east", [-1.0, -3.0, 2.0], 80.0),
        photograph("a/north", [-1.1, -2.9, 2.0], 30.0),
        photograph("b/east", [-0.5, 4.0, 2.2], 100.0),
    ]
}

fn view(origin: DVec3) -> PosedCamera {
    camera(origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE)
}

/// What the passes that are compared apart would change.
fn settings() -> Settings {
    Settings { align: false, exposure_gains: false, infer: false, ..Settings::default() }
}

/// Both renderings of a view, and where the device's pixels are, relative to the eye.
fn both(
    updates: &[SceneUpdate],
    view: &View,
    mode: Mode,
    settings: Settings,
) -> (Frame, Vec<Option<DVec3>>, ReferenceFrame) {
    let mut renderer = Renderer::with_settings(gpu(), settings);
    let mut scene = Scene::new(settings);
    for update in updates {
        renderer.apply(update.clone()).expect("a good update");
        scene.apply(update.clone());
    }
    let frame = renderer.render_as(view, mode).expect("a frame");
    let places = positions(renderer.last_positions().expect("a frame"), view.size());
    (frame, places, scene.render(view, mode))
}

/// Keeps both pictures for a person to look at.
fn keep_both(frame: &Frame, reference: &ReferenceFrame, name: &str) {
    keep(frame, &format!("{name}-device"));
    let bytes = |p: &Pixel| {
        let [r, g, b] = (p.rgb * 255.0).round().to_array().map(|c| c as u8);
        [r, g, b, 255]
    };
    let rgba = reference.pixels.iter().flat_map(bytes).collect();
    keep(&Frame { rgba, ..frame.clone() }, &format!("{name}-reference"));
}

/// The device shows the same places as the reference, away from edges of `step_m`.
fn assert_in_place(
    places: &[Option<DVec3>],
    reference: &ReferenceFrame,
    step_m: f64,
    least: usize,
) {
    let (compared, off_m) = farthest_off(places, reference, step_m);
    assert!(compared >= least && off_m < DEPTH_M, "{compared} places, off by up to {off_m} m");
}

/// How many places both show away from edges of `step_m`, and how far the device's are off.
fn farthest_off(places: &[Option<DVec3>], reference: &ReferenceFrame, step_m: f64) -> (usize, f64) {
    let (mut compared, mut off_m) = (0, 0.0f64);
    let edges = reference.edges(step_m);
    for ((edge, found), expected) in edges.into_iter().zip(places).zip(&reference.pixels) {
        if edge {
            continue;
        }
        assert_eq!(found.is_some(), expected.place.is_some(), "{expected:?}");
        let (Some(found), Some(expected)) = (found, expected.place) else { continue };
        compared += 1;
        off_m = off_m.max(found.distance(expected.position));
    }
    (compared, off_m)
}

/// Each mode, without lens: the same surfaces, the same colours, the same places.
#[test]
fn the_street_with_its_pole() {
    let updates = street(DVec3::ZERO);
    let view = View::from(view(DVec3::ZERO));
    for mode in [
        Mode::Hybrid,
        Mode::Mesh,
        Mode::Points,
        Mode::PointsColour,
        Mode::Depth,
        Mode::Normals,
        Mode::Sources,
        Mode::Uncertainty,
    ] {
        let (frame, places, reference) = both(&updates, &view, mode, settings());
        keep_both(&frame, &reference, &format!("street-{mode:?}"));
        let difference = reference.difference(&frame);
        let points_only = matches!(mode, Mode::Points | Mode::PointsColour);
        let (colours, geometry) = if points_only { (9_000, 300) } else { (40_000, 38_000) };
        assert!(difference.compared > colours, "{mode:?}: {difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{mode:?}: {difference:?}");
        assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{mode:?}: {difference:?}");
        assert_in_place(&places, &reference, STEP_M, geometry);
    }
}

/// Each way of texturing points: all are one picture, which is the reference's.
#[test]
fn points_textured_in_every_way() {
    let updates = street(DVec3::ZERO);
    let view = View::from(view(DVec3::ZERO));
    for mode in [Mode::Hybrid, Mode::Points, Mode::Sources] {
        let (colours, points) = if mode == Mode::Points { (9_000, 9_000) } else { (40_000, 5_000) };
        for texturing in Texturing::ALL {
            let what = format!("{}-{}", mode.name(), texturing.name());
            let settings = Settings { texturing, ..settings() };
            let (frame, _, reference) = both(&updates, &view, mode, settings);
            keep_both(&frame, &reference, &what);
            let coloured = frame.surfaces.iter().filter(|s| **s == Surface::PointColoured).count();
            assert!(coloured > points, "{what}: {coloured} pixels");
            let difference = reference.difference(&frame);
            assert!(difference.compared > colours, "{what}: {difference:?}");
            assert!(difference.alike >= FRAME_ALIKE_SHARE, "{what}: {difference:?}");
            assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{what}: {difference:?}");
        }
    }
}

/// Each setting that changes the picture.
#[test]
fn other_settings() {
    let mut updates = street(DVec3::ZERO);
    for update in &mut updates {
        if let SceneUpdate::Points(chunk) = update {
            // Not those of the surface: discs then lie on planes that are inclined otherwise.
            let normals = [[-0.8, 0.6, 0.0], [0.0; 3], [-0.6, 0.0, -0.8]];
            let chunk = Arc::make_mut(chunk);
            chunk.normals = (0..chunk.positions.len()).map(|i| normals[i / 97 % 3]).collect();
        }
    }
    let view = View::from(view(DVec3::ZERO));
    let default = settings();
    for settings in [
        Settings { splat_normals: SplatNormals::Estimated, ..default },
        Settings { depth_test: false, ..default },
        Settings { refine_by_points: false, depth_map_side: 192, ..default },
        Settings { rigs: 1, splat_scale: 1.0, max_splat_radius_m: 0.05, ..default },
        // Discs that do not touch.
        Settings { max_splat_radius_m: 0.02, ..default },
    ] {
        let (frame, places, reference) = both(&updates, &view, Mode::Hybrid, settings);
        keep_both(&frame, &reference, "settings");
        let difference = reference.difference(&frame);
        assert!(difference.compared > 33_000, "{settings:?}: {difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{settings:?}: {difference:?}");
        assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{settings:?}: {difference:?}");
        assert_in_place(&places, &reference, STEP_M, 30_000);
    }
}

/// A distorted view looks its surfaces up in an ideal one's pixels, so that between discs another
/// one may be shown: the wall is uncertain enough to be points throughout, all of one colour.
#[test]
fn photographs_and_view_through_lenses() {
    let brown = Distortion::Brown { k: [-0.1, 0.02, 0.0], p: [0.002, 0.001] };
    let street = Street::with_pole(DVec3::ZERO);
    let mut updates = photographs(&street, PHOTO, brown);
    updates.push(mesh_update(street.mesh(&[0, 2, 3], 0.3)));
    updates.push(points_update(street.points(&[0], 0.1)));
    let intrinsics = Intrinsics { fx: 135.0, fy: 131.0, cx: 123.0, cy: 88.0 };
    for distortion in [
        Distortion::RadialPixels {
            centre: DVec2::new(118.0, 92.0),
            k: [-9e-6, 1.2e-10, -5e-16],
            limit_px: 300.0,
        },
        Distortion::Brown { k: [0.2, 0.1, 0.0], p: [0.01, -0.008] },
        Distortion::Fisheye { k: [-0.02, 0.004, 0.0, 0.0] },
    ] {
        let lens = Lens { size: SIZE, intrinsics, distortion };
        let view = View::from(with_lens(view(DVec3::ZERO), lens));
        let (frame, places, reference) = both(&updates, &view, Mode::Hybrid, settings());
        keep_both(&frame, &reference, "lens");
        let difference = reference.difference(&frame);
        assert!(difference.compared > 38_000, "{distortion:?}: {difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{distortion:?}: {difference:?}");
        assert_in_place(&places, &reference, DEPTH_M, 35_000);
    }
}

/// Plan and elevation.
#[test]
fn views_without_perspective() {
    let updates = street_taken(DVec3::ZERO, COARSE_PHOTO);
    let plan = View::orthographic(DVec3::new(-1.0, 0.0, 30.0), 0.2, -FRAC_PI_2, 20.0, SIZE);
    let elevation = View::orthographic(DVec3::new(-4.0, 0.5, 3.0), 1.4, -0.1, 8.0, SIZE);
    for view in [plan, elevation] {
        for mode in [Mode::Hybrid, Mode::Depth, Mode::Points] {
            let (frame, places, reference) = both(&updates, &view, mode, settings());
            keep_both(&frame, &reference, "orthographic");
            let difference = reference.difference(&frame);
            assert!(difference.compared > 10_000, "{mode:?}: {difference:?}");
            assert!(difference.alike >= FRAME_ALIKE_SHARE, "{mode:?}: {difference:?}");
            assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{mode:?}: {difference:?}");
            // Each disc of the pole is a step.
            let least = if mode == Mode::Points { 0 } else { 10_000 };
            assert_in_place(&places, &reference, STEP_M, least);
        }
    }
}

/// Far from the origin of coordinates, up to where f64 itself holds 15 nm: places are good to a
/// fiftieth of a millimetre, wherever the street is and however little the eye moves, so that
/// nothing jitters.
#[test]
fn far_coordinates() {
    let origins = [
        DVec3::new(651_187.3, 6_861_353.6, 42.8),
        DVec3::new(100_000.1, -0.3, 2.7),
        DVec3::splat(1e8),
    ];
    for origin in origins {
        let updates = street_taken(origin, COARSE_PHOTO);
        for millimetres in 0..3 {
            let aside = 1e-3 * f64::from(millimetres);
            let at = [-0.8 + aside, 0.5 - aside, 1.8];
            let view = View::from(camera(origin, at, 88.0, 3.0, 60.0, SIZE / 2));
            let (frame, places, reference) = both(&updates, &view, Mode::Hybrid, settings());
            let difference = reference.difference(&frame);
            assert!(difference.compared > 8_000, "{origin}: {difference:?}");
            assert!(difference.alike >= FRAME_ALIKE_SHARE, "{origin}: {difference:?}");
            let (compared, off_m) = farthest_off(&places, &reference, STEP_M);
            assert!(compared > 7_000 && off_m < JITTER_M, "{origin}: {off_m} m of {compared}");
        }
    }
}

/// At Lambert-93 coordinates, near and from 50 m away: there with photographs of which the full level
/// is looked up, and with larger ones.
#[test]
fn the_street_in_lambert_93() {
    let origin = DVec3::new(651_187.3, 6_861_353.6, 42.8);
    let far = camera(origin, [-44.0, 3.0, 5.0], 91.0, 1.0, 15.0, SIZE);
    for (camera, photo, least) in
        [(view(origin), PHOTO, 38_000), (far, COARSE_PHOTO, 30_000), (far, PHOTO, 30_000)]
    {
        let updates = street_taken(origin, photo);
        let (frame, places, reference) =
            both(&updates, &View::from(camera), Mode::Hybrid, settings());
        keep_both(&frame, &reference, "lambert");
        let difference = reference.difference(&frame);
        assert!(difference.compared > least, "{difference:?}");
        if camera == far && photo == PHOTO {
            assert!(difference.p99_255 <= FRAME_MINIFIED_255, "{difference:?}");
        } else {
            assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
        }
        assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{difference:?}");
        assert_in_place(&places, &reference, STEP_M, least);
    }
}

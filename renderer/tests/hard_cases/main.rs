//! Hard cases of cameras, lenses and meshes, each against the reference in f64 or against what
//! is documented. Those of points are in `src/splat/tests/`.

#[path = "../common/mod.rs"]
mod common;
mod lenses;
mod refused;
mod surfaces;

use std::f64::consts::FRAC_PI_2;

use common::*;
use flaneur_renderer::reference::{Difference, Scene};
use flaneur_renderer::{Frame, Mode, RenderError, Settings, Surface};
use flaneur_scene::{
    Distortion, Footprint, Intrinsics, Lens, Polygon, PosedCamera, SceneUpdate, SurfaceClass,
    TileKey, TileLayer, View, extrude_footprints,
};
use glam::{DMat3, DVec2, DVec3, UVec2};
use tolerances::{FRAME_ALIKE_SHARE, FRAME_MINIFIED_255};

const SIZE: UVec2 = UVec2::new(160, 120);
const PHOTO: UVec2 = UVec2::new(160, 120);

fn settings() -> Settings {
    Settings { align: false, exposure_gains: false, infer: false, ..Settings::default() }
}

fn view() -> PosedCamera {
    camera(DVec3::ZERO, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE)
}

fn photo_camera(at: [f64; 3], heading: f64) -> PosedCamera {
    camera(DVec3::ZERO, at, heading, 5.0, 70.0, PHOTO)
}

/// The whole street as mesh, seen by one photograph more.
fn street_and(photographs: &[(&str, PosedCamera)]) -> Vec<SceneUpdate> {
    let street = Street::with_pole(DVec3::ZERO);
    let photograph =
        |(id, camera): &(&str, PosedCamera)| image_update(street.photograph(id, *camera));
    let mut updates: Vec<SceneUpdate> = photographs.iter().map(photograph).collect();
    updates.push(mesh_update(street.mesh(&[0, 1, 2, 3], 0.0)));
    updates
}

/// The device's frame, and how far it is from the reference's.
fn compared(updates: &[SceneUpdate], camera: PosedCamera) -> (Frame, Difference) {
    compared_with(settings(), updates, camera)
}

fn compared_with(
    settings: Settings,
    updates: &[SceneUpdate],
    camera: PosedCamera,
) -> (Frame, Difference) {
    let view = View::from(camera);
    let frame = renderer(settings, updates.to_vec()).render(&view).expect("a frame");
    let mut scene = Scene::new(settings);
    updates.iter().for_each(|update| scene.apply(update.clone()));
    let difference = scene.render(&view, Mode::Hybrid).difference(&frame);
    (frame, difference)
}

/// Compares with the reference; at least `least` pixels away from edges. Gives the frame.
fn assert_alike(updates: &[SceneUpdate], camera: PosedCamera, least: usize, what: &str) -> Frame {
    let (frame, difference) = compared(updates, camera);
    keep(&frame, what);
    assert!(difference.compared >= least, "{what}: {difference:?}");
    let shares = difference.alike.min(difference.same_surface);
    assert!(shares >= FRAME_ALIKE_SHARE, "{what}: {difference:?}");
    frame
}

fn count(frame: &Frame, test: impl Fn(Surface) -> bool) -> usize {
    frame.surfaces.iter().filter(|&&surface| test(surface)).count()
}

#[test]
fn the_eye_at_the_centre_of_a_photograph() {
    let own = photo_camera([-1.0, -3.0, 2.0], 80.0);
    let updates = street_and(&[("a/x", own), ("b/x", photo_camera([-0.5, 4.0, 2.2], 100.0))]);
    // Exactly there, a nanometre beside, and turned.
    for (offset, heading) in [(0.0, 80.0), (1e-9, 80.0), (0.0, 101.0)] {
        let at = [-1.0, -3.0 + offset, 2.0];
        let eye = camera(DVec3::ZERO, at, heading, 3.0, 60.0, SIZE);
        let frame = assert_alike(&updates, eye, 15_000, "zero baseline");
        assert!(count(&frame, Surface::is_coloured) > 9_000);
        // Nothing of that photograph moves, nor does its exposure.
        let (_, difference) = compared_with(Settings::default(), &updates, eye);
        assert!(difference.compared > 15_000, "{difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
    }
}

#[test]
fn nothing_at_all_in_every_mode() {
    let background = [9, 8, 7];
    let mut empty = renderer(Settings { background, ..settings() }, Vec::new());
    for mode in Mode::ALL {
        let frame = empty.render_as(&view().into(), mode).expect("a frame");
        assert!(frame.rgba.chunks_exact(4).all(|pixel| pixel == [9, 8, 7, 255]), "{mode:?}");
    }
}

//! Exposure gains: the device's factors against f64, and the frames that they make.

use flaneur_scene::{ImageUpdate, SceneUpdate, View, linear_from_srgb, srgb_from_linear};
use glam::{DVec3, UVec2};

use super::common::{Street, camera, image_update, mesh_update, points_update};
use super::{SIZE, Scene, both, keep_both, settings};
use crate::kernel_tests::gpu;
use crate::tolerances::{FRAME_ALIKE_SHARE, GAIN_LOGARITHM};
use crate::{Mode, Renderer, Settings};

/// For linear red, green and blue.
const EXPOSURES: [[f64; 3]; 5] =
    [[1.0, 1.0, 0.95], [0.6, 0.62, 0.6], [0.95, 0.9, 0.9], [0.55, 0.55, 0.6], [0.8, 0.75, 0.85]];

/// The photograph as if it had been exposed for so much longer.
pub(super) fn exposed(mut image: ImageUpdate, by: [f64; 3]) -> ImageUpdate {
    for pixel in image.rgba.chunks_exact_mut(4) {
        for (value, by) in pixel.iter_mut().zip(by) {
            let linear = linear_from_srgb(f64::from(*value) / 255.0) * by;
            *value = (255.0 * srgb_from_linear(linear)).round() as u8;
        }
    }
    image
}

/// Photographs along a wall, each with its own exposure, the last one seen past a pole of points;
/// and one that looks away, and so has no say in the view's.
fn updates(origin: DVec3) -> Vec<SceneUpdate> {
    let street = Street::with_pole(origin);
    let mut updates =
        vec![mesh_update(street.mesh(&[0, 2, 3], 0.05)), points_update(street.points(&[1], 0.03))];
    for (i, exposure) in (0..).zip(EXPOSURES) {
        let at = [-1.0, -5.0 + 2.5 * f64::from(i), 2.0 + 0.1 * f64::from(i)];
        let camera = camera(origin, at, 90.0, 5.0, 70.0, UVec2::new(480, 360));
        let image = street.photograph(&format!("{i}/x"), camera);
        updates.push(image_update(exposed(image, exposure)));
    }
    let away = camera(origin, [-1.0, -5.0, 2.0], 270.0, 5.0, 70.0, UVec2::new(480, 360));
    updates.push(image_update(street.photograph("0/away", away)));
    updates
}

fn view(origin: DVec3) -> View {
    View::from(camera(origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE))
}

#[test]
fn gains_agree_with_their_reference() {
    let with_gains = Settings { exposure_gains: true, ..settings() };
    for origin in [DVec3::ZERO, DVec3::new(651_187.3, 6_861_353.6, 42.8)] {
        let mut renderer = Renderer::with_settings(gpu(), with_gains);
        let mut scene = Scene::new(with_gains);
        for update in updates(origin) {
            scene.apply(update.clone());
            renderer.apply(update).expect("a good update");
        }
        renderer.render(&view(origin)).expect("a frame");
        let expected = scene.gains(&view(origin));
        assert_eq!(expected.len(), EXPOSURES.len() + 1);
        for (id, expected) in expected {
            if id.to_string() == "0/away" {
                assert_eq!(expected, DVec3::ONE);
                continue;
            }
            let off = (renderer.last_gain(&id) / expected).map(|share| share.ln().abs());
            println!("{id}: {expected}, off by {off}");
            assert!(off.max_element() < GAIN_LOGARITHM, "{id}: {expected}, off by {off}");
            assert!((expected - 1.0).abs().max_element() > 0.02, "{id}: {expected}");
        }
    }
}

#[test]
fn frames_with_gains() {
    let with_gains = Settings { exposure_gains: true, ..settings() };
    let view = view(DVec3::ZERO);
    for mode in [Mode::Hybrid, Mode::Sources] {
        let (frame, _, reference) = both(&updates(DVec3::ZERO), &view, mode, with_gains);
        keep_both(&frame, &reference, &format!("gains-{mode:?}"));
        let difference = reference.difference(&frame);
        assert!(difference.compared > 38_000, "{difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
    }
}

//! Whole frames of a street that is known exactly.

mod common;

use common::*;
use flaneur_renderer::Settings;
use flaneur_scene::View;
use glam::{DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(320, 240);

/// Photographs looking at the wall from two places, and all surfaces as mesh.
fn updates(street: &Street) -> Vec<flaneur_scene::SceneUpdate> {
    let everything: Vec<usize> = (0..=street.blocks.len()).collect();
    let photo = UVec2::new(640, 480);
    let at = |place: [f64; 3], heading| camera(street.origin, place, heading, 5.0, 70.0, photo);
    vec![
        mesh_update(street.mesh(&everything, 0.0)),
        image_update(street.photograph("a/east", at([-1.0, -3.0, 2.0], 80.0))),
        image_update(street.photograph("b/east", at([-0.5, 4.0, 2.2], 100.0))),
    ]
}

#[test]
fn mesh_and_photographs_give_the_picture_of_another_place() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(Settings::default(), updates(&street));
    let view = View { camera: camera(street.origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE) };
    let frame = renderer.render(&view).expect("a frame");
    assert_eq!(frame.stats.images_drawn, 2);
    let truth = street.picture(&view.camera);
    let (mut checked, mut wrong, mut sum) = (0u32, 0u32, 0.0);
    for (i, seen) in truth.iter().enumerate() {
        let interior = is_interior(&truth, SIZE, i, 2);
        let Some((_, colour)) = seen else {
            assert!(!interior || !frame.surfaces[i].is_geometry(), "sky at {i}");
            continue;
        };
        if interior {
            assert!(frame.surfaces[i].is_geometry(), "no hole at {i}");
        }
        if interior && frame.surfaces[i].is_coloured() {
            let off = difference(&frame.rgba, i, *colour);
            checked += 1;
            sum += off;
            wrong += u32::from(off > 6.0);
        }
    }
    if std::env::var_os("FLANEUR_TEST_IMAGES").is_some() {
        image::save_buffer(
            std::env::temp_dir().join("street.png"),
            &frame.rgba,
            SIZE.x,
            SIZE.y,
            image::ColorType::Rgba8,
        )
        .expect("png");
    }
    let (mean, share) = (sum / f64::from(checked), f64::from(wrong) / f64::from(checked));
    println!(
        "{checked} pixels, mean {mean:.3}, wrong {share:.5}, coverage {}",
        frame.stats.coverage()
    );
    assert!(checked > 40_000, "{checked}");
    assert!(mean < 1.0 && share < 0.001, "mean {mean}/255, {share} wrong");
}

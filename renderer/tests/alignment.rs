//! Photographs whose poses are off by centimetres.

mod common;

use common::*;
use flaneur_renderer::Settings;
use flaneur_scene::{ImageUpdate, PosedCamera, SceneUpdate, View};
use glam::{DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(512, 384);
const PHOTO: UVec2 = UVec2::new(640, 480);

/// Two photographs of a wall, each said to be `off` from its place, to either side.
fn updates(street: &Street, off: DVec3) -> Vec<SceneUpdate> {
    let taken = |id: &str, y: f64, off: DVec3| {
        let camera = camera(street.origin, [-0.9, y, 1.9], 90.0, 10.0, 80.0, PHOTO);
        let image = street.photograph(id, camera);
        image_update(ImageUpdate {
            camera: PosedCamera { centre: camera.centre + off, ..camera },
            ..image
        })
    };
    let everything: Vec<usize> = (0..=street.blocks.len()).collect();
    vec![
        taken("a/east", -0.6, off),
        taken("b/east", 0.6, -off),
        mesh_update(street.mesh(&everything, 0.0)),
    ]
}

fn missed(street: &Street, off: DVec3, align: bool) -> f64 {
    let view = View::from(camera(street.origin, [-0.8, 0.0, 1.8], 90.0, 8.0, 60.0, SIZE));
    let settings = Settings { align, infer: false, exposure_gains: false, ..Settings::default() };
    let frame = renderer(settings, updates(street, off)).render(&view).expect("a frame");
    keep(&frame, &format!("alignment-{align}"));
    street.likeness(&frame, &view.camera, 3).mean
}

fn street() -> Street {
    let blocks = vec![block([5.0, -20.0, 0.0], [9.0, 20.0, 9.0])];
    Street { blocks, spots: 0.5, ..Street::with_pole(DVec3::ZERO) }
}

/// What is shown twice, aside of itself, is shown once.
#[test]
fn photographs_that_are_off_are_made_to_agree() {
    let street = street();
    for off in [DVec3::new(0.0, 0.08, 0.0), DVec3::new(0.0, 0.0, 0.08)] {
        let [aligned, apart] = [true, false].map(|align| missed(&street, off, align));
        println!("off by {off}: {apart:.2} of 255 without alignment, {aligned:.2} with it");
        assert!(aligned < 0.7 * apart, "{aligned} {apart}");
    }
}

/// Those that agree already stay as they are.
#[test]
fn photographs_that_agree_are_not_moved() {
    let street = street();
    let [aligned, apart] = [true, false].map(|align| missed(&street, DVec3::ZERO, align));
    println!("{apart:.3} of 255 without alignment, {aligned:.3} with it");
    assert!(aligned < apart + 0.2, "{aligned} {apart}");
}

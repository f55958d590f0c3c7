//! What a renderer holds of the device's memory.

mod common;

use common::*;
use flaneur_renderer::{MemoryReport, Settings};
use glam::{DVec3, UVec2};

#[test]
fn memory_is_counted_by_kind() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(Settings::default(), Vec::new());
    let empty = renderer.memory();
    assert_eq!((empty.points, empty.mesh, empty.targets), (0, 0, 0));
    let camera = camera(street.origin, [-1.0, -2.0, 2.0], 90.0, 5.0, 70.0, UVec2::new(320, 240));
    for (update, of) in [
        (mesh_update(street.mesh(&[0, 3], 0.1)), (|m| m.mesh) as fn(&MemoryReport) -> u64),
        (points_update(street.points(&[1], 0.05)), |m| m.points),
        (image_update(street.photograph("a/x", camera)), |m| m.photographs),
    ] {
        let before = renderer.memory();
        renderer.apply(update).expect("a good update");
        let after = renderer.memory();
        assert!(of(&after) > of(&before), "{before:?} {after:?}");
        assert_eq!(after.total() - before.total(), of(&after) - of(&before), "one kind grows");
    }
    // A level of 1024 pixels a side with four below it.
    let photographs = [1024u64, 512, 256, 128, 64].map(|side| 4 * side * side).iter().sum::<u64>();
    assert!(renderer.memory().photographs >= photographs);
    renderer.render(&camera.into()).expect("a frame");
    let targets = renderer.memory().targets;
    let pixels = 320 * 240;
    assert!((60 * pixels..400 * pixels).contains(&targets), "{targets}");
    let large = camera.lens.scaled_to(UVec2::new(640, 480));
    renderer.render(&with_lens(camera, large).into()).expect("a frame");
    let ratio = renderer.memory().targets as f64 / targets as f64;
    assert!((ratio - 4.0).abs() < 0.2, "four times the pixels: {ratio}");
}

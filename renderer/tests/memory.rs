//! What a renderer holds of the device's memory.

mod common;

use common::*;
use std::collections::BTreeMap;

use flaneur_renderer::{MemoryReport, RenderError, Settings};
use flaneur_scene::{ImageId, NodeKey, PointChunk, PointNodeId, SceneUpdate, View};
use glam::{DVec3, UVec2};
use proptest::prelude::*;

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

/// Room for one texture of photographs, some twenty thousand points, and few depth maps.
fn scarce() -> Settings {
    Settings { gpu_memory_bytes: 16 << 20, depth_map_side: 64, ..Settings::default() }
}

fn small_view() -> View {
    camera(DVec3::ZERO, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, UVec2::new(96, 64)).into()
}

/// A node of the pole's points, `x` to the east: a full level of 60 thousand.
fn node(street: &Street, level: u32, x: u32) -> PointChunk {
    let mut chunk = street.points(&[1], 0.012);
    chunk.id.key = NodeKey { level, x, y: 0, z: 0 };
    chunk.origin += DVec3::X * f64::from(x) * 4.0;
    chunk.spacing_m = 0.5 / (1u32 << level) as f32;
    chunk
}

fn photograph(street: &Street, index: u32) -> SceneUpdate {
    let at = [-1.0, f64::from(index) * 2.0 - 6.0, 2.0];
    let camera = camera(street.origin, at, 90.0, 5.0, 70.0, UVec2::new(500, 400));
    image_update(street.photograph(&format!("{index}/x"), camera))
}

/// What is told to be resident, by update.
#[derive(Default)]
struct Ledger {
    points: BTreeMap<PointNodeId, SceneUpdate>,
    images: BTreeMap<ImageId, SceneUpdate>,
}

impl Ledger {
    fn note(&mut self, update: &SceneUpdate) {
        match update {
            SceneUpdate::Points(chunk) => _ = self.points.insert(chunk.id, update.clone()),
            SceneUpdate::DropPoints(id) => _ = self.points.remove(id),
            SceneUpdate::Image(image) => _ = self.images.insert(image.id.clone(), update.clone()),
            SceneUpdate::DropImage(id) => _ = self.images.remove(id),
            SceneUpdate::Mesh(_) | SceneUpdate::DropMesh(_) => {}
        }
    }

    fn updates(&self) -> Vec<SceneUpdate> {
        self.points.values().chain(self.images.values()).cloned().collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..Default::default() })]

    /// Whatever comes and goes, the budget holds, and what was evicted leaves no trace: the frame
    /// is that of a renderer that holds the rest alone.
    #[test]
    fn the_budget_is_never_exceeded(
        steps in prop::collection::vec((0u32..5, 0u32..6, 0u32..3), 6..14)
    ) {
        let street = Street::with_pole(DVec3::ZERO);
        let mesh = mesh_update(street.mesh(&[0, 2, 3], 0.1));
        let mut scarce_renderer = renderer(scarce(), vec![mesh.clone()]);
        let mut ledger = Ledger::default();
        for (what, index, level) in steps {
            let update = match what {
                0 | 1 => points_update(node(&street, level, index)),
                2 | 3 => photograph(&street, index),
                _ => SceneUpdate::DropImage(format!("{index}/x").parse().expect("a name")),
            };
            let applied = scarce_renderer.apply(update.clone()).expect("never an error");
            ledger.note(&update);
            applied.evicted.iter().for_each(|dropped| ledger.note(dropped));
            let memory = scarce_renderer.memory();
            prop_assert!(memory.total() <= scarce().gpu_memory_bytes, "{memory:?}");
            let frame = scarce_renderer.render(&small_view()).expect("a frame");
            prop_assert_eq!(frame.stats.images as usize, ledger.images.len());
            let memory = scarce_renderer.memory();
            prop_assert!(memory.total() <= scarce().gpu_memory_bytes, "{memory:?}");
        }
        scarce_renderer.cut();
        let frame = scarce_renderer.render(&small_view()).expect("a frame");
        let mut updates = vec![mesh];
        updates.extend(ledger.updates());
        let mut fresh = renderer(Settings { gpu_memory_bytes: 8 << 30, ..scarce() }, updates);
        let expected = fresh.render(&small_view()).expect("a frame");
        prop_assert!(frame.surfaces == expected.surfaces, "other surfaces");
        // Photographs lie elsewhere in their textures, where filtering rounds otherwise.
        let off = frame.rgba.iter().zip(&expected.rgba).map(|(a, b)| a.abs_diff(*b)).max();
        prop_assert!(off <= Some(2), "another picture: {off:?}");
    }
}

#[test]
fn what_is_far_makes_room_for_what_is_near_and_not_the_reverse() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(scarce(), Vec::new());
    renderer.expect_eye(DVec3::new(-1.0, -6.0, 2.0));
    let mut evicted = Vec::new();
    for index in (0..6).rev() {
        let applied = renderer.apply(photograph(&street, index)).expect("never an error");
        assert!(!applied.refused, "each is nearer than all before it");
        evicted.extend(applied.evicted);
    }
    let ids: Vec<String> = evicted
        .iter()
        .map(|update| match update {
            SceneUpdate::DropImage(id) => id.to_string(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(!ids.is_empty() && ids.len() < 6, "{ids:?}");
    let farthest_first: Vec<String> = (0..6).rev().map(|i| format!("{i}/x")).collect();
    assert_eq!(ids, farthest_first[..ids.len()]);
    // What was given up is refused when it comes again, and displaces nothing.
    let again = renderer.apply(photograph(&street, 5)).expect("never an error");
    assert!(again.refused && again.evicted.len() == 1, "{again:?}");

    let coarse = points_update(node(&street, 0, 0));
    renderer.apply(coarse).expect("fits");
    let mut gone = Vec::new();
    for x in 1..5 {
        gone.extend(renderer.apply(points_update(node(&street, 2, x))).expect("no error").evicted);
    }
    assert!(!gone.is_empty(), "there is no room for five");
    let is_coarse = |update: &SceneUpdate| matches!(update, SceneUpdate::DropPoints(id) if id.key == NodeKey::ROOT);
    assert!(!gone.iter().any(is_coarse), "the coarse level stays: {gone:?}");
}

#[test]
fn a_picture_that_does_not_fit_is_refused() {
    let mut renderer = renderer(scarce(), Vec::new());
    let mut view = small_view();
    view.camera.lens = view.camera.lens.scaled_to(UVec2::new(1024, 512));
    let error = renderer.render(&view).expect_err("it needs 80 MB");
    assert!(matches!(error, RenderError::ViewMemory { budget: 16_777_216, .. }), "{error}");
    renderer.render(&small_view()).expect("a smaller one");
}

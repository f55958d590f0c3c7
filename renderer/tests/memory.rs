//! What a renderer holds of the device's memory.

mod common;

use common::*;
use std::collections::BTreeMap;
use std::sync::Arc;

use flaneur_renderer::{MemoryReport, RenderError, Settings, Texturing};
use flaneur_scene::{
    ImageId, ImageUpdate, MeshTile, MeshVertex, NodeKey, PointChunk, PointNodeId, SceneUpdate,
    SurfaceClass, TileKey, TileLayer, View, linear_from_srgb, srgb_from_linear,
};
use glam::{DVec3, UVec2};
use proptest::prelude::*;
use tolerances::ELSEWHERE_255;

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

#[test]
fn what_only_pictures_need_is_counted() {
    let street = Street::with_pole(DVec3::ZERO);
    let updates = vec![
        mesh_update(street.mesh(&[0, 2, 3], 0.1)),
        points_update(street.points(&[1], 0.05)),
        photograph(&street, 1),
        photograph(&street, 3),
    ];
    let mut renderer = renderer(Settings::default(), updates);
    let before = renderer.memory();
    let bare = [before.targets, before.inference, before.sprites, before.gains];
    assert_eq!(bare, [0; 4]);
    renderer.render(&small_view()).expect("a frame");
    let deferred = renderer.memory();
    // 24 × 16 cells with ten hypotheses, three half floats each for four rigs and more.
    assert!(deferred.inference > 24 * 16 * 10 * 4 * 4, "{deferred:?}");
    assert!(deferred.alignment > before.alignment + 24 * 16 * 16, "{deferred:?}");
    // Two photographs lend 256 places each.
    assert!(deferred.gains >= 512 * (16 + 2 * 2 * 8) && deferred.sprites == 0, "{deferred:?}");
    let settings = Settings { texturing: Texturing::Homography, ..Settings::default() };
    assert!(renderer.set_settings(settings));
    renderer.render(&small_view()).expect("a frame");
    let forward = renderer.memory();
    assert!(forward.sprites > 96 * 64 * 16 && forward.alignment == before.alignment, "{forward:?}");
    assert_eq!(forward.kinds().iter().map(|(_, bytes)| bytes).sum::<u64>(), forward.total());
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

/// The photograph at its next level, as the device makes it: colours in linear light.
fn halved(image: &ImageUpdate) -> ImageUpdate {
    let size = image.size / 2;
    let linear = |byte: u8| linear_from_srgb(f64::from(byte) / 255.0);
    let mut rgba = Vec::new();
    for (y, x) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (y, x))) {
        let texels = [[0, 0], [1, 0], [0, 1], [1, 1]]
            .map(|[i, j]| 4 * ((2 * y + j) * image.size.x + 2 * x + i) as usize);
        for channel in 0..3 {
            let mean = texels.iter().map(|at| linear(image.rgba[at + channel])).sum::<f64>() / 4.0;
            rgba.push((255.0 * srgb_from_linear(mean)).round() as u8);
        }
        rgba.push(255);
    }
    ImageUpdate { level: image.level + 1, size, rgba, ..image.clone() }
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

    fn make_coarser(&mut self, id: &ImageId, level: u32) {
        let Some(SceneUpdate::Image(image)) = self.images.get_mut(id) else { panic!("{id}") };
        while image.level < level {
            *image = Arc::new(halved(image));
        }
    }

    fn updates(&self) -> Vec<SceneUpdate> {
        self.points.values().chain(self.images.values()).cloned().collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..Default::default() })]

    /// Whatever comes and goes, the limit holds, and what was evicted leaves no trace: the frame
    /// is that of a renderer that holds the rest alone.
    #[test]
    fn the_limit_is_never_exceeded(
        steps in prop::collection::vec((0u32..7, 0u32..12, 0u32..3), 6..18)
    ) {
        let street = Street::with_pole(DVec3::ZERO);
        let mesh = mesh_update(street.mesh(&[0, 2, 3], 0.1));
        let mut scarce_renderer = renderer(scarce(), vec![mesh.clone()]);
        let mut ledger = Ledger::default();
        for (what, index, level) in steps {
            let update = match what {
                0 | 1 => points_update(node(&street, level, index)),
                2..=4 => photograph(&street, index),
                5 => {
                    let texturing = Texturing::ALL[level as usize];
                    scarce_renderer.set_settings(Settings { texturing, ..scarce() });
                    continue;
                }
                _ => SceneUpdate::DropImage(format!("{index}/x").parse().expect("a name")),
            };
            let applied = scarce_renderer.apply(update.clone()).expect("never an error");
            let known = matches!(&update, SceneUpdate::Image(i) if ledger.images.contains_key(&i.id));
            if !(applied.refused && known) {
                ledger.note(&update);
            }
            applied.coarser.iter().for_each(|(id, level)| ledger.make_coarser(id, *level));
            applied.evicted.iter().for_each(|dropped| ledger.note(dropped));
            let memory = scarce_renderer.memory();
            prop_assert!(memory.total() <= scarce().gpu_memory_bytes, "{memory:?}");
            let frame = scarce_renderer.render(&small_view()).expect("a frame");
            prop_assert_eq!(frame.stats.images as usize, ledger.images.len());
            prop_assert!(scarce_renderer.point_nodes().eq(ledger.points.keys().copied()));
            let memory = scarce_renderer.memory();
            prop_assert!(memory.total() <= scarce().gpu_memory_bytes, "{memory:?}");
        }
        scarce_renderer.set_settings(scarce());
        scarce_renderer.cut();
        let frame = scarce_renderer.render(&small_view()).expect("a frame");
        let mut updates = vec![mesh];
        updates.extend(ledger.updates());
        let mut fresh = renderer(Settings { gpu_memory_bytes: 8 << 30, ..scarce() }, updates);
        let expected = fresh.render(&small_view()).expect("a frame");
        prop_assert!(frame.surfaces == expected.surfaces, "other surfaces");
        // Photographs lie elsewhere in their textures, where filtering rounds otherwise.
        let off = frame.rgba.iter().zip(&expected.rgba).map(|(a, b)| a.abs_diff(*b)).max();
        let alike = off.is_some_and(|off| f64::from(off) <= ELSEWHERE_255);
        prop_assert!(alike, "another picture: {off:?}");
    }
}

#[test]
fn what_is_far_makes_room_for_what_is_near_and_not_the_reverse() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(scarce(), Vec::new());
    renderer.expect_eye(DVec3::new(-1.0, -6.0, 2.0));
    let mut coarser: BTreeMap<String, u32> = BTreeMap::new();
    for index in (0..6).rev() {
        let applied = renderer.apply(photograph(&street, index)).expect("never an error");
        assert!(!applied.refused, "each is nearer than all before it");
        assert!(applied.evicted.is_empty(), "those that are far become coarser first");
        coarser.extend(applied.coarser.into_iter().map(|(id, level)| (id.to_string(), level)));
    }
    // There is room for four, and the pixels of what is far are of least use.
    assert_eq!(coarser.keys().map(String::as_str).collect::<Vec<_>>(), ["4/x", "5/x"]);
    // What was made coarser is refused when it comes again, stays, and displaces nothing.
    let again = renderer.apply(photograph(&street, 5)).expect("never an error");
    assert!(again.refused && again.evicted.is_empty(), "{again:?}");
    let id: ImageId = "5/x".parse().expect("a name");
    assert_eq!(again.coarser, [(id, coarser["5/x"])]);
    let frame = renderer.render(&small_view()).expect("a frame");
    assert_eq!(frame.stats.images, 6);

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
fn what_cannot_be_coarser_is_given_up_farthest_first() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(scarce(), Vec::new());
    renderer.expect_eye(DVec3::new(-1.0, -6.0, 2.0));
    let small = |index: u32| {
        let at = [-1.0, f64::from(index) * 0.5 - 6.0, 2.0];
        let size = UVec2::splat(128);
        let camera = camera(street.origin, at, 90.0, 5.0, 70.0, size);
        image_update(ImageUpdate {
            id: format!("{index}/x").parse().expect("a name"),
            level: 3,
            camera,
            size,
            rgba: vec![200; 128 * 128 * 4],
            uncertainty_m: 0.0,
        })
    };
    let mut evicted = Vec::new();
    // A layer holds 64.
    for index in (0..67).rev() {
        let applied = renderer.apply(small(index)).expect("never an error");
        assert!(!applied.refused && applied.coarser.is_empty(), "{applied:?}");
        evicted.extend(applied.evicted.iter().map(|update| match update {
            SceneUpdate::DropImage(id) => id.to_string(),
            other => panic!("{other:?}"),
        }));
    }
    assert_eq!(evicted, ["66/x", "65/x", "64/x"]);
    let again = renderer.apply(small(66)).expect("never an error");
    assert!(again.refused && again.evicted.len() == 1 && again.coarser.is_empty(), "{again:?}");
}

/// A photograph of this many pixels a side, so far to the north of the eye.
fn square(street: &Street, name: &str, side: u32, north_m: f64) -> SceneUpdate {
    let at = [-1.0, north_m - 6.0, 2.0];
    let camera = camera(street.origin, at, 90.0, 5.0, 70.0, UVec2::splat(side));
    image_update(ImageUpdate {
        id: format!("{name}/x").parse().expect("a name"),
        level: 0,
        camera,
        size: UVec2::splat(side),
        rgba: (0..side * side).flat_map(|i| [(i % 251) as u8, 90, 200, 255]).collect(),
        uncertainty_m: 0.0,
    })
}

/// A far photograph could be made coarser and then be given up for the new one, but near ones leave
/// no room for it all the same.
#[test]
fn a_photograph_that_is_refused_costs_others_nothing() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(scarce(), vec![mesh_update(street.mesh(&[0, 2, 3], 0.1))]);
    renderer.expect_eye(DVec3::new(-1.0, -6.0, 2.0));
    for (name, north_m) in [("near", 0.1), ("beside", 0.2), ("far", 10.0), ("farther", 12.0)] {
        let applied = renderer.apply(square(&street, name, 500, north_m)).expect("never an error");
        assert!(!applied.refused && applied.coarser.is_empty(), "{applied:?}");
    }
    let before = (renderer.memory(), renderer.render(&small_view()).expect("a frame"));
    renderer.expect_eye(DVec3::new(-1.0, -6.0, 2.0));
    let applied = renderer.apply(square(&street, "new", 1000, 2.0)).expect("never an error");
    let id: ImageId = "new/x".parse().expect("a name");
    assert!(applied.refused && applied.coarser.is_empty(), "{applied:?}");
    let only_itself =
        |gone: &[SceneUpdate]| matches!(gone, [SceneUpdate::DropImage(gone)] if *gone == id);
    assert!(only_itself(&applied.evicted), "{applied:?}");
    assert_eq!(renderer.memory().photographs, before.0.photographs);
    renderer.cut();
    assert!(renderer.render(&small_view()).expect("a frame") == before.1, "another picture");
    // Half as large it needs no more than those two give.
    renderer.expect_eye(DVec3::new(-1.0, -6.0, 2.0));
    let applied = renderer.apply(square(&street, "new", 500, 2.0)).expect("never an error");
    let coarser: Vec<String> = applied.coarser.iter().map(|(id, _)| id.to_string()).collect();
    assert!(!applied.refused && applied.evicted.is_empty(), "{applied:?}");
    assert!(!coarser.is_empty() && coarser.iter().all(|id| id.starts_with("far")), "{applied:?}");
}

/// Triangles so far to the east, 108 bytes each.
fn triangles(street: &Street, x: i32, count: u32) -> MeshTile {
    let vertex = |i: u32| {
        let [along, up] = [f32::from(u8::from(i % 3 == 1)), f32::from(u8::from(i % 3 == 2))];
        let position =
            [x as f32, along + 0.01 * (i / 300) as f32, up + 0.01 * (i / 3 % 100) as f32];
        let (normal, class) = ([-1.0, 0.0, 0.0], SurfaceClass::Wall);
        MeshVertex { position, normal, uncertainty_m: 0.1, class }
    };
    MeshTile {
        key: TileKey { layer: TileLayer::Footprints, x, y: 0 },
        origin: street.origin,
        vertices: (0..3 * count).map(vertex).collect(),
        indices: (0..3 * count).collect(),
    }
}

/// There is a mebibyte for meshes.
#[test]
fn the_farthest_mesh_makes_room_and_what_is_refused_costs_others_nothing() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(scarce(), Vec::new());
    renderer.expect_eye(DVec3::ZERO);
    let mut apply = |x, count| {
        let update = mesh_update(triangles(&street, x, count));
        let applied = renderer.apply(update).expect("never an error");
        let evicted = applied.evicted.iter().map(|update| match update {
            SceneUpdate::DropMesh(key) => key.x,
            other => panic!("{other:?}"),
        });
        (applied.refused, evicted.collect::<Vec<i32>>(), renderer.memory().mesh)
    };
    for (x, held) in [(10, 1), (40, 2), (30, 3)] {
        assert_eq!(apply(x, 3000), (false, vec![], held * 324_000));
    }
    // The farthest goes, and only for what is nearer.
    assert_eq!(apply(20, 3000), (false, vec![40], 972_000));
    assert_eq!(apply(40, 3000), (true, vec![40], 972_000));
    // Two would have to go, of which one is nearer: neither does.
    assert_eq!(apply(25, 6000), (true, vec![25], 972_000));
    // The room of what is replaced counts.
    assert_eq!(apply(20, 3100), (false, vec![], 982_800));
    assert_eq!(apply(20, 6000), (false, vec![30], 972_000));
    // Farthest first, no more than needed.
    assert_eq!(apply(30, 600), (false, vec![], 1_036_800));
    assert_eq!(apply(5, 900), (false, vec![30, 20], 421_200));
    // What is replaced and does not fit is gone: it is not what it was any more.
    assert_eq!(apply(10, 9000), (true, vec![10], 97_200));
}

#[test]
fn a_picture_that_does_not_fit_is_refused() {
    let mut renderer = renderer(scarce(), Vec::new());
    let mut view = small_view();
    view.camera.lens = view.camera.lens.scaled_to(UVec2::new(1024, 512));
    let error = renderer.render(&view).expect_err("it needs 80 MB");
    assert!(matches!(error, RenderError::ViewMemory { most: 16_777_216, .. }), "{error}");
    renderer.render(&small_view()).expect("a smaller one");
}

//! What is resident: changes in any order, bad updates, and next to nothing.

mod common;

use common::*;
use flaneur_renderer::{RenderError, Settings, Surface};
use flaneur_scene::{NodeKey, PointChunk, PointNodeId, PointStations, SceneUpdate, View};
use glam::{DMat3, DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(160, 120);

fn view() -> View {
    View::from(camera(DVec3::ZERO, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE))
}

fn photograph(street: &Street, id: &str, at: [f64; 3]) -> SceneUpdate {
    let camera = camera(street.origin, at, 90.0, 5.0, 70.0, UVec2::new(320, 240));
    image_update(street.photograph(id, camera))
}

/// The pole's points in two nodes of an octree, the coarse one a tenth of the fine one's.
fn nodes(street: &Street) -> [PointChunk; 2] {
    let mut fine = street.points(&[1], 0.04);
    let mut coarse = fine.clone();
    coarse.positions = fine.positions.iter().step_by(10).copied().collect();
    coarse.spacing_m = 0.16;
    fine.id.key = NodeKey { level: 2, x: 1, y: 2, z: 3 };
    [coarse, fine]
}

#[test]
fn the_order_of_arrival_does_not_matter() {
    let street = Street::with_pole(DVec3::ZERO);
    let [coarse, fine] = nodes(&street).map(points_update);
    let mesh = mesh_update(street.mesh(&[0, 2, 3], 0.1));
    let a = photograph(&street, "a/x", [-1.0, -2.0, 2.0]);
    let b = photograph(&street, "b/x", [-1.0, 3.0, 2.0]);
    let all = [mesh, a, b, coarse, fine];
    let expected = renderer(Settings::default(), all.to_vec()).render(&view()).expect("a frame");
    assert!(expected.stats.coverage() > 0.9);
    for order in [[4, 3, 2, 1, 0], [3, 0, 4, 2, 1], [1, 4, 0, 3, 2]] {
        let mut renderer = renderer(Settings::default(), Vec::new());
        for i in order {
            renderer.apply(all[i].clone()).expect("a good update");
            // Depth maps are drawn now, and refined by what comes later.
            renderer.render(&view()).expect("a frame");
        }
        let frame = renderer.render(&view()).expect("a frame");
        assert!(frame.surfaces == expected.surfaces, "order {order:?} gives other surfaces");
        // Photographs lie elsewhere in their textures, where filtering rounds otherwise.
        let off = frame.rgba.iter().zip(&expected.rgba).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off <= Some(1), "order {order:?} gives another picture: {off:?}");
    }
}

#[test]
fn what_is_dropped_leaves_no_trace() {
    let street = Street::with_pole(DVec3::ZERO);
    let [coarse, fine] = nodes(&street);
    let mesh = street.mesh(&[0, 2, 3], 0.1);
    let kept = [
        mesh_update(mesh.clone()),
        photograph(&street, "a/x", [-1.0, -2.0, 2.0]),
        points_update(coarse),
    ];
    let mut extra = street.mesh(&[1], 0.1);
    extra.key.x = 7;
    let extra_key = extra.key;
    let mut renderer_here = renderer(Settings::default(), kept.to_vec());
    let expected = renderer_here.render(&view()).expect("a frame");
    let b = photograph(&street, "b/x", [-1.0, 3.0, 2.0]);
    for update in [mesh_update(extra), b, points_update(fine.clone())] {
        renderer_here.apply(update).expect("a good update");
    }
    let between = renderer_here.render(&view()).expect("a frame");
    assert!(between != expected);
    for update in [
        SceneUpdate::DropMesh(extra_key),
        SceneUpdate::DropImage("b/x".parse().expect("a name")),
        SceneUpdate::DropPoints(fine.id),
        SceneUpdate::DropPoints(fine.id),
    ] {
        renderer_here.apply(update).expect("dropping is never wrong");
    }
    assert!(renderer_here.render(&view()).expect("a frame") == expected);
}

/// A photograph arrives coarse and is replaced by finer levels: the picture sharpens and
/// nothing else changes.
#[test]
fn a_finer_level_replaces_a_coarser_one() {
    let street = Street::with_pole(DVec3::ZERO);
    let camera = camera(street.origin, [-1.0, -2.0, 2.0], 90.0, 5.0, 70.0, UVec2::new(640, 480));
    let mut view = view();
    view.camera = with_lens(view.camera, view.camera.lens.scaled_to(camera.lens.size));
    let mut renderer =
        renderer(Settings::default(), vec![mesh_update(street.mesh(&[0, 1, 2, 3], 0.0))]);
    let mut means = Vec::new();
    for level in (0..=4u32).rev() {
        let size = camera.lens.size / (1 << level);
        let coarse = with_lens(camera, camera.lens.scaled_to(size));
        let mut image = street.photograph("a/x", coarse);
        image.level = level;
        image.camera = camera;
        renderer.apply(image_update(image)).expect("a good update");
        let frame = renderer.render(&view).expect("a frame");
        assert_eq!(frame.stats.images, 1);
        means.push(street.likeness(&frame, &view.camera, 2).mean);
    }
    assert!(means.windows(2).all(|pair| pair[1] < pair[0] + 0.1), "{means:?}");
    assert!(means[4] < tolerances::RESAMPLED_MEAN_255, "{means:?}");
}

#[test]
fn next_to_nothing_is_a_picture_too() {
    let settings = Settings { background: [1, 2, 3], ..Settings::default() };
    let mut empty = renderer(settings, Vec::new());
    let frame = empty.render(&view()).expect("a frame");
    assert!(frame.rgba.chunks_exact(4).all(|pixel| pixel == [1, 2, 3, 255]));
    assert!(frame.surfaces.iter().all(|&surface| surface == Surface::Background));
    assert_eq!(frame.stats.coverage(), 0.0);

    // One point straight ahead, with a colour of its own, beside some that are no points.
    let eye = view().eye();
    let ahead = (view().camera.forward() * 5.0).as_vec3();
    let nan = [f32::NAN, 0.0, 0.0];
    let infinite = [0.0, f32::INFINITY, 0.0];
    let chunk = PointChunk {
        id: PointNodeId { source: 3, key: NodeKey::ROOT },
        origin: eye,
        positions: vec![nan, ahead.to_array(), infinite, [0.0; 3], [0.0, 0.0, 1e9]],
        colours: vec![[9; 3], [200, 100, 50], [9; 3], [9; 3], [9; 3]],
        intensities: Vec::new(),
        classes: Vec::new(),
        normals: Vec::new(),
        stations: PointStations::default(),
        spacing_m: 0.1,
        spacings_m: Vec::new(),
    };
    empty.apply(points_update(chunk.clone())).expect("bad points are left out");
    let frame = empty.render(&view()).expect("a frame");
    assert_eq!((frame.stats.points, frame.stats.points_refused), (2, 3));
    let middle = (SIZE.y / 2 * SIZE.x + SIZE.x / 2) as usize;
    assert_eq!(frame.rgba[4 * middle..4 * middle + 4], [200, 100, 50, 255]);
    assert_eq!(frame.surfaces[middle], Surface::PointUncoloured);

    let none = PointChunk { positions: Vec::new(), colours: Vec::new(), ..chunk };
    empty.apply(points_update(none)).expect("no points are fine");
    assert_eq!(empty.render(&view()).expect("a frame").stats.points, 0);
}

/// Every thread of the splat pass wants the same pixels.
#[test]
fn a_million_points_on_one_pixel_come_to_an_end() {
    let position = (view().camera.forward() * 3.0).as_vec3().to_array();
    let chunk = PointChunk {
        id: PointNodeId { source: 0, key: NodeKey::ROOT },
        origin: view().eye(),
        positions: vec![position; 1_000_000],
        colours: Vec::new(),
        intensities: Vec::new(),
        classes: Vec::new(),
        normals: Vec::new(),
        stations: PointStations::default(),
        spacing_m: 0.01,
        spacings_m: Vec::new(),
    };
    let mut renderer = renderer(Settings::default(), vec![points_update(chunk)]);
    let frame = renderer.render(&view()).expect("a frame");
    assert!((1..20).contains(&frame.stats.geometry_pixels), "{:?}", frame.stats);
}

/// Points are held in pages of 8192 blocks: those on a second one are seen beside those on the first,
/// before them and behind them.
#[test]
fn points_of_several_pages_are_one_picture() {
    let street = Street::with_pole(DVec3::ZERO);
    let of_source = |source: u16, chunk: PointChunk| PointChunk {
        id: PointNodeId { source, key: NodeKey::ROOT },
        colours: vec![[60 * source as u8 + 60, 90, 30]; chunk.positions.len()],
        ..chunk
    };
    let near = of_source(0, street.points(&[1], 0.04));
    let behind_the_eye = |x: u32| PointChunk {
        id: PointNodeId { source: 1, key: NodeKey { level: 14, x, y: 0, z: 0 } },
        positions: vec![[-30.0, 0.0, 1.0]],
        colours: Vec::new(),
        ..near.clone()
    };
    let far = of_source(2, street.points(&[0, 2, 3], 0.1));
    let drawn = |fillers: u32| {
        let mut renderer = renderer(Settings::default(), vec![points_update(near.clone())]);
        for x in 0..fillers {
            renderer.apply(points_update(behind_the_eye(x))).expect("a good update");
        }
        renderer.apply(points_update(far.clone())).expect("a good update");
        let frame = renderer.render(&view()).expect("a frame");
        (frame, renderer.memory().points)
    };
    let ((one_page, bytes), (two_pages, more_bytes)) = (drawn(0), drawn(8192));
    assert!(more_bytes >= 2 * bytes, "{bytes} and {more_bytes} bytes");
    let shown = |red: u8| one_page.rgba.chunks_exact(4).filter(|pixel| pixel[0] == red).count();
    assert!(shown(60) > 50 && shown(180) > 1000, "{} and {}", shown(60), shown(180));
    assert!(one_page.rgba == two_pages.rgba && one_page.surfaces == two_pages.surfaces);
}

#[test]
fn bad_updates_are_refused_and_change_nothing() {
    let street = Street::with_pole(DVec3::ZERO);
    let mesh = street.mesh(&[0, 3], 0.1);
    let camera = camera(street.origin, [-1.0, -2.0, 2.0], 90.0, 5.0, 70.0, UVec2::new(64, 48));
    let image = street.photograph("a/x", camera);
    let points = street.points(&[1], 0.1);
    let good =
        vec![mesh_update(mesh.clone()), image_update(image.clone()), points_update(points.clone())];
    let mut renderer = renderer(Settings::default(), good);
    let expected = renderer.render(&view()).expect("a frame");

    let mut bad_index = mesh;
    bad_index.indices[4] = 1000;
    let mut short = image.clone();
    short.rgba.pop();
    let mut skewed = image.clone();
    skewed.camera.cam_from_world = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1.1));
    let mut blind = image.clone();
    blind.camera.lens.intrinsics.fx = 0.0;
    let mut nowhere = image;
    nowhere.camera.centre.x = f64::NAN;
    let mut columns = points.clone();
    columns.colours = vec![[0; 3]; 2];
    let mut dense = points;
    dense.spacing_m = 0.0;
    let mut refusals = Vec::new();
    for update in [
        mesh_update(bad_index),
        image_update(short),
        image_update(skewed),
        image_update(blind),
        image_update(nowhere),
        points_update(columns),
        points_update(dense),
    ] {
        refusals.push(renderer.apply(update).expect_err("refused").to_string());
    }
    for (text, part) in refusals.iter().zip([
        "triangle index 1000 is out of range",
        "image a/x: 12287 bytes cannot be a picture of 64x48 pixels",
        "image a/x: its orientation is no rotation",
        "image a/x: its focal lengths must be positive",
        "image a/x: its centre is not finite",
        "2 colours for",
        "spacing positive, found 0 m",
    ]) {
        assert!(text.contains(part), "{text:?} lacks {part:?}");
    }
    assert!(renderer.render(&view()).expect("a frame") == expected);

    let mut view = view();
    view.camera.lens.size = UVec2::new(0, 10);
    assert!(matches!(renderer.render(&view), Err(RenderError::ViewSize { .. })));
    view.camera.lens.size = UVec2::splat(60_000);
    assert!(matches!(renderer.render(&view), Err(RenderError::ViewSize { .. })));
    view.camera.lens.size = SIZE;
    view.camera.centre.z = f64::INFINITY;
    assert!(matches!(renderer.render(&view), Err(RenderError::ViewCamera { .. })));
}

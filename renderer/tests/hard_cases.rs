//! Hard cases of cameras, lenses and meshes, each against the reference in f64 or against what
//! is documented. Those of points are in `src/splat/tests/`.

mod common;

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
    let view = View::from(camera);
    let frame = renderer(settings(), updates.to_vec()).render(&view).expect("a frame");
    let mut scene = Scene::new(settings());
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
    }
}

/// A photograph taken from the plane of a wall sees nothing of it: it has no say on it, and
/// nothing divides by the cosine that is 0.
#[test]
fn a_photograph_from_the_plane_of_a_wall() {
    let street = Street::with_pole(DVec3::ZERO);
    for x in [6.0, 6.0 - 1e-6, 6.0 + 1e-6] {
        let along = photo_camera([x, -26.0, 2.0], 0.0);
        let updates = street_and(&[("a/x", along)]);
        let frame = assert_alike(&updates, view(), 15_000, "on the plane");
        let truth = street.picture(&view());
        let on_wall = |i: usize| truth[i].is_some_and(|(hit, _)| hit.object == 0);
        let (mut walls, mut others) = (0, 0);
        for (i, surface) in frame.surfaces.iter().enumerate() {
            assert!(!(on_wall(i) && surface.is_coloured()), "{x}: coloured from its own plane");
            walls += u32::from(on_wall(i));
            others += u32::from(surface.is_coloured());
        }
        assert!(walls > 5000 && others > 500, "{walls} {others}");
    }
}

/// A lens of each model that folds back within its own picture.
fn folding_lenses(size: UVec2) -> Vec<Lens> {
    let half = size.as_dvec2() / 2.0;
    let focal = half.y;
    let intrinsics = Intrinsics { fx: focal, fy: 0.97 * focal, cx: half.x + 3.0, cy: half.y - 2.0 };
    let centre = half + DVec2::new(-2.0, 4.0);
    let k = [-0.4 / focal.powi(2), 0.0, 0.0];
    [
        Distortion::RadialPixels { centre, k, limit_px: f64::INFINITY },
        // Says itself that it ends before it would fold.
        Distortion::RadialPixels { centre, k, limit_px: 0.6 * focal },
        Distortion::Brown { k: [-0.4, 0.0, 0.0], p: [0.004, -0.003] },
        Distortion::Fisheye { k: [-0.35, 0.0, 0.0, 0.0] },
    ]
    .map(|distortion| Lens { size, intrinsics, distortion })
    .into()
}

/// Beyond the limit of its lens a photograph shows nothing, in particular not its own mirror
/// image.
#[test]
fn photographs_whose_lens_folds_back() {
    let street = Street::with_pole(DVec3::ZERO);
    let wide = camera(DVec3::ZERO, [-0.8, 0.5, 1.8], 88.0, 3.0, 100.0, SIZE);
    let truth = street.picture(&wide);
    for lens in folding_lenses(PHOTO) {
        let camera = with_lens(photo_camera([-1.0, 0.0, 2.0], 85.0), lens);
        let updates = street_and(&[("a/x", camera)]);
        let frame = assert_alike(&updates, wide, 14_000, "folding photograph");
        let (mut beyond, mut within) = (0, 0);
        for (i, seen) in truth.iter().enumerate() {
            let Some((hit, _)) = seen.filter(|_| is_interior(&truth, SIZE, i, 1)) else { continue };
            let c = camera.cam_from_world(hit.position);
            // Just within the limit either answer is right.
            let seen = |scale: f64| lens.project(c * DVec3::new(scale, scale, 1.0)).is_some();
            if !seen(0.999) {
                beyond += 1;
                assert!(!frame.surfaces[i].is_coloured(), "{lens:?} pixel {i}");
            } else if seen(1.001) {
                within += usize::from(frame.surfaces[i].is_coloured());
            }
        }
        assert!(beyond > 2000 && within > 2000, "{lens:?}: {beyond} beyond, {within} within");
    }
}

/// The pixels of a view that its lens does not reach are background, and the others show the
/// street, except for up to 8 pixels before the limit.
#[test]
fn views_whose_lens_folds_back() {
    let street = Street::with_pole(DVec3::ZERO);
    let updates = street_and(&[("a/x", photo_camera([-1.0, 0.0, 2.0], 85.0))]);
    for lens in folding_lenses(SIZE) {
        let camera = with_lens(view(), lens);
        let frame = renderer(settings(), updates.clone()).render(&camera.into()).expect("a frame");
        keep(&frame, "folding view");
        let truth = street.picture(&camera);
        let reached: Vec<bool> = pixels(SIZE).map(|p| lens.unproject(p).is_some()).collect();
        let (mut beyond, mut within) = (0, 0);
        for (i, pixel) in pixels(SIZE).enumerate() {
            let around = |reach: i32| {
                (-reach..=reach).all(|dy| {
                    (-reach..=reach).all(|dx| {
                        let p = pixel + DVec2::new(dx.into(), dy.into());
                        lens.unproject(p).is_some()
                    })
                })
            };
            if !reached[i] {
                beyond += 1;
                assert_eq!(frame.surfaces[i], Surface::Background, "{lens:?} at {pixel}");
            } else if is_interior(&truth, SIZE, i, 2) && around(8) {
                within += 1;
                assert_eq!(frame.surfaces[i].is_geometry(), truth[i].is_some(), "{pixel}");
            }
        }
        assert!(beyond > 2000 && within > 500, "{lens:?}: {beyond} beyond, {within} within");
    }
}

/// A view of 179°, and one in which a pixel is a tenth of a millimetre; photographs likewise.
#[test]
fn focal_lengths_of_one_and_of_a_hundred_thousand_pixels() {
    let with_focal = |camera: PosedCamera, focal: f64| {
        let mut lens = camera.lens;
        (lens.intrinsics.fx, lens.intrinsics.fy) = (focal, focal);
        with_lens(camera, lens)
    };
    let normal = photo_camera([-1.0, -0.5, 2.0], 85.0);
    let other = photo_camera([-0.5, 4.0, 2.2], 100.0);
    // A photograph of 1 px a tangent shows 160° in eleven pixels.
    for (focal, coloured) in [(1.0, 20), (1e5, 10_000)] {
        let extreme = with_focal(normal, focal);
        let updates = street_and(&[("a/x", extreme), ("b/x", other)]);
        assert_alike(&updates, view(), 15_000, &format!("photograph {focal}"));
        let updates = street_and(&[("a/x", normal), ("b/x", other)]);
        let eye = with_focal(view(), focal);
        assert_alike(&updates, eye, 12_000, &format!("view {focal}"));
        // Both: the photograph's pixels are the view's.
        let updates = street_and(&[("a/x", extreme)]);
        let turned = PosedCamera { lens: eye.lens, ..extreme };
        let frame = assert_alike(&updates, turned, 12_000, &format!("both {focal}"));
        assert!(
            count(&frame, Surface::is_coloured) > coloured,
            "{focal}: {}",
            count(&frame, Surface::is_coloured)
        );
    }
}

/// Pictures one pixel wide or high, as photographs and as views.
#[test]
fn images_of_one_column_or_row() {
    let street = Street::with_pole(DVec3::ZERO);
    for size in [UVec2::new(1, 90), UVec2::new(90, 1), UVec2::ONE] {
        let lens = |focal: f64| {
            let half = size.as_dvec2() / 2.0;
            Lens::pinhole(size, Intrinsics { fx: focal, fy: focal, cx: half.x, cy: half.y })
        };
        // Wide enough that the one pixel covers something.
        let narrow = with_lens(photo_camera([-1.0, -0.5, 2.0], 85.0), lens(20.0));
        let (frame, _) = compared(&street_and(&[("a/x", narrow)]), view());
        let coloured = count(&frame, Surface::is_coloured);
        assert!(coloured > 5, "{size}: {coloured} pixels");
        let updates = street_and(&[("a/x", photo_camera([-1.0, -0.5, 2.0], 85.0))]);
        let eye = with_lens(view(), lens(70.0));
        let (frame, difference) = compared(&updates, eye);
        assert!(difference.max_255 <= FRAME_MINIFIED_255, "{size}: {difference:?}");
        for (i, seen) in street.picture(&eye).iter().enumerate() {
            assert_eq!(frame.surfaces[i].is_geometry(), seen.is_some(), "{size} pixel {i}");
        }
        // Refined photographs and levels of detail of such pictures.
        let distortion = Distortion::Brown { k: [-0.1, 0.0, 0.0], p: [0.0; 2] };
        let bent = Lens { distortion, ..lens(20.0) };
        let (frame, _) = compared(&street_and(&[("a/x", with_lens(narrow, bent))]), view());
        assert!(count(&frame, Surface::is_coloured) > 5, "{size}, distorted");
    }
}

/// A wall, and a sheet a millimetre before it: from 10 m away the sheet hides all of the wall,
/// straight on and aslant.
#[test]
fn two_surfaces_a_millimetre_apart() {
    for origin in [DVec3::ZERO, DVec3::new(651_000.3, 6_861_000.7, 41.9)] {
        let street = Street { origin, blocks: vec![wall(6.0)], ground_m: 0.0 };
        let before = Street { blocks: vec![wall(5.999)], ..street.clone() };
        let mut sheet = before.mesh(&[0], 0.0);
        sheet.key.x = 1;
        sheet.vertices.iter_mut().for_each(|vertex| vertex.class = SurfaceClass::Roof);
        let both = vec![mesh_update(street.mesh(&[0], 0.0)), mesh_update(sheet.clone())];
        for heading in [90.0, 55.0, 20.0] {
            let aside = [-4.0, 0.0, 2.0];
            let view = View::from(camera(origin, aside, heading, 0.0, 50.0, SIZE));
            let frame = renderer(settings(), both.clone()).render(&view).expect("a frame");
            let alone = renderer(settings(), vec![mesh_update(sheet.clone())]);
            let expected = { alone }.render(&view).expect("a frame");
            assert!(count(&frame, Surface::is_geometry) > 1000, "{heading}");
            assert!(frame.rgba == expected.rgba, "{origin} {heading}: the wall shows through");
        }
    }
}

fn wall(x: f64) -> Block {
    block([x, -60.0, 0.0], [10.0, 60.0, 9.0])
}

/// Footprints that share a wall, each with triangles of its own on the same plane: which of them
/// shows where does not depend on the order of arrival, nor does it change between frames.
#[test]
fn coplanar_footprints() {
    let building = |x: i32, south: f64, north: f64, class: SurfaceClass| {
        let block = block([6.0, south, 0.0], [10.0, north, 9.0]);
        let street = Street { origin: DVec3::ZERO, blocks: vec![block], ground_m: 0.0 };
        let mut tile = street.mesh(&[0], 0.0);
        tile.key.x = x;
        tile.vertices.iter_mut().for_each(|vertex| vertex.class = class);
        mesh_update(tile)
    };
    let tiles = [
        building(0, -7.0, 3.0, SurfaceClass::Wall),
        building(1, -2.0, 9.0, SurfaceClass::Roof),
        building(2, -2.0, 3.0, SurfaceClass::Ground),
    ];
    let view = View::from(view());
    let frame = |order: [usize; 3]| {
        let updates = order.map(|i| tiles[i].clone()).to_vec();
        let mut renderer = renderer(settings(), updates);
        let frame = renderer.render(&view).expect("a frame");
        assert!(renderer.render(&view).expect("a frame") == frame);
        frame
    };
    let expected = frame([0, 1, 2]);
    assert!(count(&expected, Surface::is_geometry) > 10_000);
    for order in [[2, 1, 0], [1, 0, 2], [1, 2, 0]] {
        assert!(frame(order) == expected, "{order:?}");
    }
}

/// A slab without height beside a tower of 2 km.
#[test]
fn buildings_without_height_and_of_two_kilometres() {
    let square = |west: f64, south: f64, side: f64| Polygon {
        rings: vec![
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                .map(|(x, y)| DVec2::new(west + side * x, south + side * y))
                .into(),
        ],
    };
    let footprint = |west: f64, height_m: f64| Footprint {
        id: String::new(),
        polygons: vec![square(west, 20.0, 30.0)],
        base_m: 0.0,
        height_m,
        uncertainty_m: 0.1,
        attributes: "{}".to_owned(),
    };
    let key = TileKey { layer: TileLayer::Footprints, x: 0, y: 0 };
    let origin = DVec3::new(0.0, 20.0, 0.0);
    let tile =
        extrude_footprints(key, origin, &[footprint(-40.0, 0.0), footprint(5.0, 2000.0)], 0.0);
    assert_eq!(tile.indices.len() / 3, 2 + 8 + 2, "the slab has no walls");
    let updates = [mesh_update(tile)];
    // From before them; from above, where the slab is a carpet; and from the tower's top.
    for (at, pitch, least) in [
        ([0.0, 0.0, 2.0], 10.0, 3000),
        ([-10.0, 0.0, 30.0], -40.0, 3000),
        ([20.0, 0.0, 2020.0], -60.0, 1000),
    ] {
        let eye = camera(DVec3::ZERO, at, 0.0, pitch, 80.0, SIZE);
        let frame = assert_alike(&updates, eye, 10_000, &format!("tower from {at:?}"));
        assert!(count(&frame, Surface::is_geometry) > least, "{at:?}");
    }
    // Straight up along it: the wall reaches to within 2 km of the zenith.
    let mut up = camera(DVec3::ZERO, [20.0, 19.0, 2.0], 0.0, 0.0, 80.0, SIZE);
    up.cam_from_world = DMat3::from_rotation_x(FRAC_PI_2 - 0.2) * up.cam_from_world;
    assert_alike(&updates, up, 10_000, "tower from below");
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

/// Cameras with something that is no number are refused, by name, as views and as photographs.
#[test]
fn cameras_that_are_no_cameras() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(settings(), street_and(&[]));
    type Spoil = fn(&mut PosedCamera, f64);
    let spoilt: [(&str, Spoil); 9] = [
        ("centre is not finite", |camera, bad| camera.centre.y = bad),
        ("orientation is no rotation", |camera, bad| camera.cam_from_world.x_axis.z = bad),
        ("focal lengths must be positive", |camera, bad| camera.lens.intrinsics.fx = bad),
        ("focal lengths must be positive", |camera, bad| camera.lens.intrinsics.fy = bad),
        ("principal point finite", |camera, bad| camera.lens.intrinsics.cx = bad),
        ("distortion is not finite", |camera, bad| {
            camera.lens.distortion = Distortion::Brown { k: [0.0, bad, 0.0], p: [0.0; 2] };
        }),
        ("distortion is not finite", |camera, bad| {
            camera.lens.distortion = Distortion::Brown { k: [0.0; 3], p: [bad, 0.0] };
        }),
        ("distortion is not finite", |camera, bad| {
            camera.lens.distortion = Distortion::Fisheye { k: [0.0, 0.0, bad, 0.0] };
        }),
        ("distortion is not finite", |camera, bad| {
            let centre = DVec2::new(bad, 0.0);
            camera.lens.distortion =
                Distortion::RadialPixels { centre, k: [0.0; 3], limit_px: 100.0 };
        }),
    ];
    let good = street.photograph("a/x", photo_camera([-1.0, -0.5, 2.0], 85.0));
    for (what, spoil) in spoilt {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut camera = view();
            spoil(&mut camera, bad);
            let error = renderer.render(&camera.into()).expect_err("no camera");
            assert!(matches!(error, RenderError::ViewCamera { .. }), "{error}");
            assert!(error.to_string().contains(what), "{bad}: {error}");
            let mut image = good.clone();
            spoil(&mut image.camera, bad);
            let error = renderer.apply(image_update(image)).expect_err("no camera").to_string();
            assert!(error.starts_with("image a/x: ") && error.contains(what), "{bad}: {error}");
        }
    }
}

/// Triangles with a corner that is no number are left out and counted; the others are drawn.
#[test]
fn meshes_with_corners_that_are_no_numbers() {
    let street = Street::with_pole(DVec3::ZERO);
    let good = street.mesh(&[0], 0.1);
    let view = View::from(view());
    let expected =
        renderer(settings(), vec![mesh_update(good.clone())]).render(&view).expect("a frame");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut tile = good.clone();
        for axis in 0..3 {
            let first = tile.vertices.len() as u32;
            let mut corners = [tile.vertices[0], tile.vertices[1], tile.vertices[2]];
            corners[axis].position[axis] = bad;
            tile.vertices.extend(corners);
            tile.indices.extend([first, first + 1, first + 2]);
        }
        let frame = renderer(settings(), vec![mesh_update(tile)]).render(&view).expect("a frame");
        assert_eq!(frame.stats.triangles_refused, 3);
        assert!(frame.rgba == expected.rgba && frame.surfaces == expected.surfaces, "{bad}");
        // Certainty and normal that are no numbers: exact, and facing up.
        let mut tile = good.clone();
        for vertex in &mut tile.vertices {
            vertex.uncertainty_m = bad;
            vertex.normal[1] = bad;
        }
        let frame = renderer(settings(), vec![mesh_update(tile)]).render(&view).expect("a frame");
        assert!(frame.stats.geometry_pixels > 1000, "{bad}");
        // A tile that is nowhere.
        let mut tile = good.clone();
        tile.origin.z = f64::from(bad);
        let frame = renderer(settings(), vec![mesh_update(tile)]).render(&view).expect("a frame");
        assert_eq!(frame.stats.geometry_pixels, 0);
        assert_eq!(frame.stats.triangles_refused as usize, good.indices.len() / 3);
    }
}

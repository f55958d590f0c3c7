//! Surfaces seen edge-on, next to each other, and of all sizes.

use super::*;

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

/// The eye on the plane of a wall, and so near to it that the wall is seen at a thousandth of a
/// degree to some degrees.
#[test]
fn a_view_along_a_wall() {
    let updates = street_and(&[("a/x", photo_camera([-1.0, -12.0, 2.0], 60.0))]);
    for (off, least) in [(0.0, 0), (1e-6, 0), (1e-3, 0), (0.02, 100), (0.2, 2000), (1.0, 5000)] {
        let eye = camera(DVec3::ZERO, [6.0 - off, -21.0, 2.0], 2.0, 3.0, 60.0, SIZE);
        let frame = assert_alike(&updates, eye, 15_000, &format!("along the wall, {off}"));
        let street = Street::with_pole(DVec3::ZERO);
        let truth = street.picture(&eye);
        let on_wall = truth.iter().flatten().filter(|(hit, _)| hit.normal == DVec3::NEG_X);
        let seen = on_wall.count();
        assert!(seen >= least, "{off}: {seen}");
        assert!(count(&frame, Surface::is_coloured) > 0);
    }
}

/// A wall, and a sheet a millimetre before it: from 10 m away the sheet hides all of the wall,
/// straight on and aslant.
#[test]
fn two_surfaces_a_millimetre_apart() {
    for origin in [DVec3::ZERO, DVec3::new(651_000.3, 6_861_000.7, 41.9)] {
        let street = Street { origin, blocks: vec![wall(6.0)], ground_m: 0.0, spots: 0.0 };
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
            assert_alike(&both, view.camera, 10_000, "a millimetre apart");
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
        let street = Street { origin: DVec3::ZERO, blocks: vec![block], ground_m: 0.0, spots: 0.0 };
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
    // Wherever whose triangle is shown, it is where all of them are.
    let mut scene = Scene::new(settings());
    tiles.iter().for_each(|tile| scene.apply(tile.clone()));
    for mode in [Mode::Depth, Mode::Normals] {
        let frame = renderer(settings(), tiles.to_vec()).render_as(&view, mode).expect("a frame");
        let difference = scene.render(&view, mode).difference(&frame);
        assert!(difference.compared > 15_000, "{mode:?}: {difference:?}");
        let shares = difference.alike.min(difference.same_surface);
        assert!(shares >= FRAME_ALIKE_SHARE, "{mode:?}: {difference:?}");
    }
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

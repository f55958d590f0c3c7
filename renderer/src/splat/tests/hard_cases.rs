//! Cases in which f32 or the equations could fail, each by its name.

use super::*;
use crate::splat::{Nearest, Route};

const BOTH: [SplatNormals; 2] = [SplatNormals::Eye, SplatNormals::Estimated];

/// A square of points before the camera, `spacing_m` apart, with the normal n.
fn square(centre: DVec3, n: DVec3, half_side_m: f64, spacing_m: f64) -> Vec<(DVec3, DVec3)> {
    let (u, v) = n.any_orthonormal_pair();
    let steps = (half_side_m / spacing_m) as i32;
    let at = |i: i32| f64::from(i) * spacing_m;
    (-steps..=steps)
        .flat_map(|i| (-steps..=steps).map(move |j| (centre + u * at(i) + v * at(j), n)))
        .collect()
}

/// N · (P − C) from 0.3 of the distance to 0 and beyond, where the sign of N is chance.
#[test]
fn grazing_planes() {
    let camera = camera(CENTRE);
    for degrees in [70.0, 84.0, 84.5, 88.0, 89.9, 90.0, 90.1, 92.0] {
        let p = DVec3::new(0.3, 0.4, 12.0);
        let toward = p.normalize();
        let angle = f64::to_radians(degrees);
        let n = toward.any_orthonormal_vector() * angle.sin() - toward * angle.cos();
        let compared = compare(&camera, &chunk(&camera, &square(p, n, 2.0, 0.25), 0.3), BOTH[1]);
        assert!(compared.covered > 20, "{degrees}: {compared:?}");
    }
}

/// Discs around the place where they begin to turn back towards the eye differ little.
#[test]
fn discs_turn_without_a_jump() {
    use super::super::reference::disc_normal;
    let toward = DVec3::new(0.2, -0.1, 1.0).normalize();
    let side = toward.any_orthonormal_vector();
    let at = |cosine: f64| {
        let n = toward * cosine + side * (1.0 - cosine * cosine).sqrt();
        disc_normal(toward, n).normalize()
    };
    for step in -3000..3000 {
        let (here, next) = (at(f64::from(step) * 1e-4), at(f64::from(step + 1) * 1e-4));
        assert!(here.distance(next) < 0.02, "at {step}: {here} {next}");
        assert!(here.dot(toward) > 0.09, "{here} hides its point");
    }
    let n = DVec3::new(0.48, 0.6, -0.64);
    assert!((disc_normal(toward, n) - disc_normal(toward, -n)).length() < 1e-15);
}

/// Discs that would reach the plane of the eye, or a point that lies on it or behind.
#[test]
fn points_on_the_plane_of_the_eye_and_behind_it() {
    let camera = camera(CENTRE);
    let (near, step) = (f64::from(NEAR_M), 1e-4);
    let depths = [-5.0, -0.05, -0.0, 0.0, 1e-30, near - step, near + step, 0.06, 0.2, 3.0];
    let points: Vec<_> = depths
        .into_iter()
        .zip(0..)
        .map(|(z, i)| {
            let aside = 0.3 * (f64::from(i) / 5.0 - 1.0);
            let n = DVec3::new(0.6, f64::from(i) - 4.0, -0.8).normalize();
            (DVec3::new(aside * z.abs().max(0.02), 0.02 * z, z), n)
        })
        .collect();
    for normals in BOTH {
        let compared = compare(&camera, &chunk(&camera, &points, 0.3), normals);
        assert!(compared.covered > 500, "{compared:?}");
    }
}

#[test]
fn points_that_are_no_numbers_are_dropped_and_counted() {
    let camera = camera(CENTRE);
    let mut bad = chunk(&camera, &[(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO); 6], 0.1);
    bad.positions[1][0] = f32::NAN;
    bad.positions[2][1] = f32::INFINITY;
    bad.positions[3][2] = f32::NEG_INFINITY;
    bad.normals[4] = [f32::NAN; 3];
    bad.normals[5] = [f32::INFINITY, 0.0, 0.0];
    let settings = Settings { splat_normals: SplatNormals::Estimated, ..Settings::default() };
    let mut store = PointStore::new(settings.splat_normals);
    store.insert(gpu(), &settings, &bad, glam::DVec3::ZERO).expect("the rest is good");
    assert_eq!((store.point_count(), store.refused), (3, 3));
    let good = chunk(&camera, &[(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO)], 0.1);
    for (normals, way) in BOTH.into_iter().flat_map(|n| ways().into_iter().map(move |r| (n, r))) {
        let shown = drawn(gpu(), &camera, &bad, way, normals);
        assert!(shown == drawn(gpu(), &camera, &good, way, normals), "{normals:?} {way:?}");
    }
}

#[test]
fn no_points_and_one_point() {
    let camera = camera(CENTRE);
    let one = [(DVec3::new(0.1, -0.2, 5.0), DVec3::new(0.0, 0.6, -0.8))];
    for normals in BOTH {
        let compared = compare(&camera, &chunk(&camera, &one, 0.2), normals);
        assert!(compared.covered >= 4, "{compared:?}");
        for way in ways() {
            let shown = drawn(gpu(), &camera, &chunk(&camera, &[], 0.2), way, normals);
            assert!(shown.iter().all(|&(_, index)| index == u32::MAX));
        }
    }
}

/// The nearest has the pixel, and of equally near ones the first.
#[test]
fn a_million_points_on_one_pixel() {
    let camera = camera(CENTRE);
    let ahead = (DVec3::new(0.0, 0.0, 10.0), DVec3::ZERO);
    let mut points = chunk(&camera, &[ahead], 0.05);
    let [x, y, z] = points.positions[0];
    let towards = (camera.cam_from_world.transpose() * DVec3::NEG_Z).as_vec3();
    let nearest = [777_777, 999_999];
    points.positions = (0..1_000_000)
        .map(|i| match i {
            i if nearest.contains(&i) => (Vec3::new(x, y, z) + towards * 0.001).to_array(),
            _ => [x, y, z],
        })
        .collect();
    points.normals = vec![[0.0; 3]; points.positions.len()];
    let pixel = (29 * SIZE.x + 51) as usize;
    let shown: Vec<_> = ways()
        .into_iter()
        .map(|way| drawn(gpu(), &camera, &points, way, SplatNormals::Eye))
        .collect();
    for (found, way) in shown.iter().zip(ways()) {
        assert_eq!(found[pixel].1, nearest[0] as u32);
        assert!(*found == shown[0], "{way:?} differs");
    }
    // As deep as f64 has it.
    points.positions = vec![points.positions[nearest[0]]];
    points.normals.truncate(1);
    let pinhole = Pinhole::for_view(&camera.lens, 4096, 1 << 20).expect("a pinhole");
    let alone = reference_points(&camera, &pinhole, &points, SplatNormals::Eye);
    let centre = DVec2::new(51.5, 29.5);
    let expected = super::nearest(&alone, pinhole.focal, pinhole.centre, centre).expect("a disc");
    let found = f64::from(f32::from_bits(shown[0][pixel].0));
    assert!((found - expected.depth_m).abs() < DEPTH_M, "{found} m for {expected:?}");
}

/// What devices let a shader bind at once may be less than what is kept of a picture's pixels.
#[test]
fn pictures_of_more_bytes_than_a_binding_may_have() {
    let bindable = gpu().device.limits().max_storage_buffer_binding_size;
    // Half of it is one word a pixel.
    let pixels = bindable.min(1 << 27) / 8 + 4096;
    let size = UVec2::new(4096, u32::try_from(pixels.div_ceil(4096)).expect("rows"));
    let nearest = Nearest::new(gpu(), size, Route::Atomic32);
    let pass = SplatPass::new(gpu(), &Settings::default());
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    for words in nearest.words() {
        pass.clear(gpu(), &mut encoder, words);
    }
    gpu().queue.submit([encoder.finish()]);
    let pairs = nearest.pairs(gpu());
    assert_eq!(pairs.len() as u64, u64::from(size.x) * u64::from(size.y));
    assert!(pairs.iter().all(|&pair| pair == (u32::MAX, u32::MAX)), "not all is emptied");
}

/// In f32, at 10 m, depths are 1 µm apart.
#[test]
fn of_two_surfaces_a_millimetre_apart_the_nearer_is_seen() {
    let camera = camera(CENTRE);
    let wall = |z: f64| square(DVec3::new(0.0, 0.0, z), DVec3::NEG_Z, 2.0, 0.04);
    // The farther one first, so that order does not help.
    let points: Vec<_> = wall(10.001).into_iter().chain(wall(10.0)).collect();
    let first_of_nearer = points.len() as u32 / 2;
    let points = chunk(&camera, &points, 0.04);
    for way in ways() {
        let shown = drawn(gpu(), &camera, &points, way, SplatNormals::Estimated);
        let seen: Vec<_> = shown.iter().filter(|&&(_, index)| index != u32::MAX).collect();
        assert!(seen.len() > 600, "{} pixels", seen.len());
        for &&(_, index) in &seen {
            assert!(index >= first_of_nearer, "{index} of the farther wall, by {way:?}");
        }
    }
}

#[test]
fn far_coordinates() {
    for centre in [DVec3::new(0.3, 0.6, 0.8), CENTRE, DVec3::new(1e8 + 0.3, -1e8 + 0.6, 0.8)] {
        let camera = camera(centre);
        for normals in BOTH {
            let compared = compare(&camera, &chunk(&camera, &everywhere(), 0.3), normals);
            assert!(compared.covered > 300 && compared.undecided < 60, "{centre}: {compared:?}");
        }
    }
}

/// All points of a chunk in one place: its box has no size.
#[test]
fn a_chunk_without_extent() {
    let camera = camera(CENTRE);
    let points = [(DVec3::new(0.4, 0.3, 6.0), DVec3::new(0.0, 0.8, -0.6)); 300];
    for normals in BOTH {
        let compared = compare(&camera, &chunk(&camera, &points, 0.2), normals);
        assert!(compared.covered >= 4, "{compared:?}");
    }
}

/// A pole of 5 cm before a wall: as wide as it is, a disc and a pixel more at most, and
/// without a hole through which the wall shows.
#[test]
fn a_pole_stays_thin_and_whole() {
    let camera = camera(CENTRE);
    let (radius_m, spacing_m, depth_m) = (0.025, 0.01, 3.0);
    let mut points = Vec::new();
    for i in -100..=100 {
        for j in 0..16 {
            let angle = f64::from(j) / 16.0 * std::f64::consts::TAU;
            let n = DVec3::new(angle.cos(), 0.0, angle.sin());
            let axis = DVec3::new(0.0, f64::from(i) * spacing_m, depth_m);
            points.push((axis + n * radius_m, n));
        }
    }
    let pole = points.len() as u32;
    points.extend(square(DVec3::new(0.0, 0.0, 9.0), DVec3::NEG_Z, 6.0, 0.05));
    let mut points = chunk(&camera, &points, 0.0134);
    // Discs of a hundredth of a metre for all: the wall need not be closed.
    points.spacing_m = (spacing_m / 0.75) as f32;
    let lens = &camera.lens.intrinsics;
    let disc_px = 0.011 * lens.fx / depth_m;
    let half_px = radius_m * lens.fx / depth_m;
    for normals in BOTH {
        for way in ways() {
            let shown = drawn(gpu(), &camera, &points, way, normals);
            for y in 10..50 {
                let on_pole: Vec<u32> =
                    (0..SIZE.x).filter(|x| shown[(y * SIZE.x + x) as usize].1 < pole).collect();
                let (first, last) = (on_pole[0], on_pole[on_pole.len() - 1]);
                assert_eq!(on_pole.len() as u32, last - first + 1, "row {y}: the wall shows");
                for x in [first, last] {
                    let off = (f64::from(x) + 0.5 - lens.cx).abs();
                    let reach = half_px + disc_px.max(f64::from(super::super::MIN_RADIUS_PX)) + 1.0;
                    assert!(off <= reach, "row {y}: {off} px off its axis");
                }
                // A pixel whose centre lies on the pole shows it.
                for x in 0..SIZE.x {
                    let off = (f64::from(x) + 0.5 - lens.cx).abs();
                    assert!(off > half_px - 0.1 || on_pole.contains(&x), "row {y}: hole at {x}");
                }
            }
        }
    }
}

/// Points of several stations, on small discs and on large ones: every way puts the same ones
/// behind others, and what is near the camera wins although it is farther away.
#[test]
fn points_of_near_stations_win_by_every_way() {
    let camera = camera(CENTRE);
    for spacing_m in [0.05f32, 0.4] {
        let plane = |z: f64| square(DVec3::new(0.0, 0.0, z), DVec3::NEG_Z, 1.6, 0.1);
        let mut points = plane(8.0);
        points.resize(points.len().next_multiple_of(BLOCK_POINTS), points[0]);
        let near = points.len();
        points.extend(plane(7.5));
        let mut chunk = chunk(&camera, &points, spacing_m);
        let station = |i: usize| u16::from(i >= near);
        chunk.stations = PointStations {
            places: [camera.centre + DVec3::X, camera.centre + 9.0 * DVec3::X].into(),
            of_points: (0..points.len()).map(station).collect(),
        };
        let shown: Vec<_> =
            ways().into_iter().map(|way| drawn(gpu(), &camera, &chunk, way, BOTH[0])).collect();
        for (other, way) in shown.iter().zip(ways()) {
            assert!(shown[0] == *other, "{way:?} differs");
        }
        let wins = |near_wins: bool| {
            let of = |&&(_, index): &&(u32, u32)| {
                index != u32::MAX && ((index as usize) < near) == near_wins
            };
            shown[0].iter().filter(of).count()
        };
        let (of_near, of_far) = (wins(true), wins(false));
        // The far ones are nearer, and so reach a little over the border.
        assert!(of_near > 20 && of_far < of_near, "{spacing_m}: {of_near} and {of_far}");
        let middle = shown[0][(SIZE.y / 2 * SIZE.x + SIZE.x / 2) as usize];
        assert!((middle.1 as usize) < near, "{middle:?}");
    }
}

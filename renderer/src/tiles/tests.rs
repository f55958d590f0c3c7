//! Pyramids against the lens that they enclose, and the lists of the device against f64.

use flaneur_scene::{Distortion, Intrinsics, Lens, PosedCamera, View, ViewProjection};
use glam::{DVec2, DVec3, UVec2};

use super::reference::{reach, sees};
use super::{Shown, TILE, TilePass, gpu_data};
use crate::frustum::Frustum;
use crate::kernel_tests::channels::records;
use crate::kernel_tests::{gpu, read};
use crate::pinhole::Pinhole;
use crate::tolerances::{PYRAMID, TILES_IN_VAIN};

const EYE: DVec3 = DVec3::new(651_187.3, 6_861_353.6, 42.8);
const LENSES: [Distortion; 3] = [
    Distortion::None,
    Distortion::Brown { k: [-0.2, 0.03, 0.0], p: [1e-3, -2e-3] },
    Distortion::Fisheye { k: [-0.02, 0.004, 0.0, 0.0] },
];

fn lens(distortion: Distortion) -> Lens {
    let intrinsics = Intrinsics { fx: 300.0, fy: 290.0, cx: 330.0, cy: 230.0 };
    Lens { size: UVec2::new(640, 480), intrinsics, distortion }
}

fn frustum(camera: &PosedCamera) -> Frustum {
    Frustum::new(camera, &Pinhole::for_depth_map(&camera.lens, 512).expect("a pinhole"))
}

#[test]
fn what_a_lens_sees_lies_inside_its_pyramid() {
    for distortion in LENSES {
        let lens = lens(distortion);
        let camera = PosedCamera { lens, ..View::look(EYE, 1.0, 0.2, 1.0, lens.size).camera };
        let frustum = frustum(&camera);
        for i in 0..400u32 {
            let share = DVec2::new(f64::from(i % 20), f64::from(i / 20)) / 19.0;
            let Some(ray) = camera.lens.unproject(share * camera.lens.size.as_dvec2()) else {
                continue;
            };
            let at = camera.cam_from_world.transpose() * (ray * 30.0);
            let inside = |p: DVec3| frustum.planes().iter().all(|(n, on)| n.dot(p - on) >= 0.0);
            assert!(inside(camera.centre + at), "{share} {distortion:?}");
            // What lies on the other side of the centre does not.
            assert!(!inside(camera.centre - at), "{share} {distortion:?}");
        }
    }
}

/// Tiles at two borders are cut.
const SIZE: UVec2 = UVec2::new(337, 210);

/// What the pixels of a view show, relative to its eye as the device has it, and whether that is
/// something: a street between two rows of houses at different distances, and some sky.
fn shown(view: &View) -> Vec<([f32; 3], bool)> {
    let world_from_cam = view.camera.cam_from_world.transpose();
    let parallel = view.projection == ViewProjection::Orthographic;
    let pixels = (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| UVec2::new(x, y)));
    pixels
        .map(|pixel| {
            let ray = view.camera.lens.unproject(pixel.as_dvec2() + 0.5).expect("no distortion");
            if parallel {
                // A slope that the camera looks down on, and half of the picture nothing.
                let place = world_from_cam * ray.with_z(30.0 + 0.5 * ray.x - 0.2 * ray.y);
                return (place.as_vec3().to_array(), pixel.x > pixel.y);
            }
            let ray = world_from_cam * ray;
            let house = 6.0 + 3.0 * (f64::from(pixel.x / 40) * 2.3).sin();
            let depth_m = (house / ray.x.abs()).min(2.0 / (-ray.z).max(0.0)).min(60.0);
            let ends = depth_m < 60.0 && ray.z < 0.5;
            let place = if ends { ray * depth_m } else { ray.normalize() };
            (place.as_vec3().to_array(), ends)
        })
        .collect()
}

/// Photographs of three rigs, in all directions and through all lenses, one of them far from what
/// is shown; with their rigs.
fn photographs() -> Vec<(PosedCamera, usize)> {
    let at = |rig: usize, offset: [f64; 3], heading: f64, pitch: f64| {
        let lens = lens(LENSES[rig]);
        let [heading, pitch] = [heading, pitch].map(f64::to_radians);
        let eye = EYE + DVec3::from_array(offset);
        (PosedCamera { lens, ..View::look(eye, heading, pitch, 1.0, lens.size).camera }, rig)
    };
    vec![
        at(0, [1.0, 4.0, 0.2], 0.0, 0.0),
        at(0, [1.1, 4.0, 0.2], 90.0, 5.0),
        at(0, [1.0, 4.1, 0.2], 180.0, -20.0),
        at(0, [1.0, 4.0, 0.3], 270.0, 0.0),
        at(1, [-2.0, 15.0, 0.0], 20.0, -5.0),
        at(1, [-2.0, 15.1, 0.0], 190.0, 10.0),
        at(2, [0.0, -300.0, 0.0], 180.0, 0.0),
        at(2, [0.5, 30.0, 9.0], 150.0, -60.0),
    ]
}

/// How a tile is listed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Listed {
    /// Apart from those that a photograph shares with others of its rig.
    apart: bool,
    /// In a square of so many tiles a side.
    side: u32,
}

/// For each photograph which tiles the device lists, and how.
fn on_device(
    view: &View,
    places: &[([f32; 3], bool)],
    photographs: &[(PosedCamera, usize)],
    apart: bool,
) -> Vec<Vec<Option<Listed>>> {
    let positions = records(SIZE, places);
    let frustums: Vec<Frustum> = photographs.iter().map(|(camera, _)| frustum(camera)).collect();
    let seen: Vec<_> = frustums.iter().zip(photographs).map(|(f, (_, rig))| (f, *rig)).collect();
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let shown = Shown { view, size: SIZE, positions: &positions };
    let pass = TilePass::new(gpu());
    let boxes = pass.boxes(gpu(), &mut encoder, shown);
    let lists = pass.lists(gpu(), &mut encoder, &seen, apart, &boxes);
    let lists = lists.expect("photographs");
    let draws: Vec<gpu_data::Draw> = read(encoder, &lists.draws);
    let encoder = gpu().device.create_command_encoder(&Default::default());
    let listed: Vec<u32> = read(encoder, &lists.lists);
    let columns = SIZE.x.div_ceil(TILE);
    let of_photograph = |index: usize| {
        let mut tiles = vec![None; lists.tile_count as usize];
        for apart in [false, true] {
            let draw = 2 * index + usize::from(apart);
            let gpu_data::Draw { vertex_count, instance_count, first_vertex, first_instance } =
                draws[draw];
            assert_eq!([vertex_count, first_vertex, first_instance], [4, 0, 0]);
            let first = draw * lists.tile_count as usize;
            for word in &listed[first..first + instance_count as usize] {
                let (first, side) = (UVec2::new(word & 0x3fff, word >> 16), 1 << (word >> 14 & 3));
                for i in 0..side * side {
                    let cell = first + UVec2::new(i % side, i / side);
                    let tile = &mut tiles[(cell.y * columns + cell.x) as usize];
                    assert_eq!(tile.replace(Listed { apart, side }), None, "listed once");
                }
            }
        }
        tiles
    };
    (0..photographs.len()).map(of_photograph).collect()
}

/// The places (world) of each tile.
fn by_tile(view: &View, places: &[([f32; 3], bool)]) -> Vec<Vec<DVec3>> {
    let columns = SIZE.x.div_ceil(TILE);
    let mut tiles = vec![Vec::new(); (columns * SIZE.y.div_ceil(TILE)) as usize];
    for (place, i) in places.iter().zip(0..) {
        let tile = i / SIZE.x / TILE * columns + i % SIZE.x / TILE;
        let (place, shows) = place;
        let world = view.eye() + DVec3::from_array(place.map(f64::from));
        tiles[tile as usize].extend(shows.then_some(world));
    }
    tiles
}

/// Along the street, across it, down onto it, and from above without perspective.
fn views() -> [View; 4] {
    let views = [(0.0, 0.0), (80.0, 5.0), (200.0, -50.0)].map(|(heading, pitch)| {
        let [heading, pitch, fov] = [heading, pitch, 65.0f64].map(f64::to_radians);
        View::look(EYE, heading, pitch, fov, SIZE)
    });
    let [along, across, down] = views;
    let above = EYE + DVec3::new(0.0, -8.0, 25.0);
    let plan = View::orthographic(above, 0.2, -70f64.to_radians(), 40.0, SIZE);
    [along, across, down, plan]
}

/// Whoever sees a place of a tile is listed for it; who is listed is whose pyramid meets the
/// tile's box; and few are listed that see nothing.
#[test]
fn lists_agree_with_their_reference() {
    let photographs = photographs();
    let (mut seeing, mut listed_in_all, mut decided) = (0, 0, 0);
    for view in views() {
        let places = shown(&view);
        let tiles = by_tile(&view, &places);
        let found = on_device(&view, &places, &photographs, true);
        for ((camera, _), found) in photographs.iter().zip(&found) {
            let pyramid = frustum(camera);
            for (places, found) in tiles.iter().zip(found) {
                let needed = places.iter().any(|&place| sees(camera, place));
                assert!(!needed || found.is_some(), "a photograph that sees a tile is not asked");
                seeing += u32::from(needed);
                listed_in_all += u32::from(found.is_some());
                let reach = reach(&pyramid, places, &view);
                if places.is_empty() || !(-PYRAMID..0.0).contains(&reach) {
                    decided += 1;
                    let expected = !places.is_empty() && reach >= 0.0;
                    assert_eq!(found.is_some(), expected, "{reach}");
                }
            }
        }
    }
    println!("{seeing} tiles are seen, {listed_in_all} listed, {decided} decided");
    assert!(seeing > 400 && decided > 1800, "{seeing} {decided}");
    let in_vain = f64::from(listed_in_all) / f64::from(seeing) - 1.0;
    assert!(in_vain < TILES_IN_VAIN, "{in_vain}");
}

/// A tile is a photograph's own where no other of its rig is listed for it.
#[test]
fn tiles_of_one_photograph_of_a_rig_are_listed_apart() {
    let photographs = photographs();
    let (mut alone, mut shared) = (0, 0);
    for view in views() {
        let places = shown(&view);
        let found = on_device(&view, &places, &photographs, true);
        for ((_, rig), tiles) in photographs.iter().zip(&found) {
            for (i, tile) in tiles.iter().enumerate() {
                let Some(Listed { apart, .. }) = tile else { continue };
                let of_rig = photographs.iter().zip(&found).filter(|((_, other), _)| other == rig);
                let rivals = of_rig.filter(|(_, tiles)| tiles[i].is_some()).count() - 1;
                assert_eq!(*apart, rivals == 0, "tile {i}");
                *(if *apart { &mut alone } else { &mut shared }) += 1;
            }
        }
        // Where nothing is listed apart the tiles are the same.
        let together = on_device(&view, &places, &photographs, false);
        for (tiles, together) in found.iter().flatten().zip(together.iter().flatten()) {
            assert_eq!(tiles.is_some(), together.is_some());
            assert!(together.is_none_or(|tile| !tile.apart));
        }
    }
    assert!(alone > 100 && shared > 100, "{alone} {shared}");
}

/// Tiles are listed in the largest squares of 4 or of 16, aligned with the picture, that are all listed alike.
#[test]
fn tiles_are_listed_in_the_largest_squares() {
    let photographs = photographs();
    let columns = SIZE.x.div_ceil(TILE);
    let mut of_side = [0; 5];
    for view in views() {
        for tiles in on_device(&view, &shown(&view), &photographs, true) {
            for (i, tile) in (0..).zip(&tiles) {
                let Some(Listed { apart, side }) = *tile else { continue };
                let at = UVec2::new(i % columns, i / columns);
                let alike = |side: u32| {
                    (0..side * side).all(|i| {
                        let cell = at / side * side + UVec2::new(i % side, i / side);
                        let inside = cell.x < columns;
                        let other = tiles.get((cell.y * columns + cell.x) as usize);
                        let other = other.copied().flatten().filter(|_| inside);
                        other.is_some_and(|other| other.apart == apart)
                    })
                };
                let largest = [4, 2, 1].into_iter().find(|&side| alike(side));
                assert_eq!(Some(side), largest, "tile {at}");
                of_side[side as usize] += 1;
            }
        }
    }
    assert!([1, 2, 4].map(|side| of_side[side] >= 16) == [true; 3], "{of_side:?}");
}

//! The splat pass against a reference that tries every point at every pixel.

use flaneur_scene::{
    Intrinsics, Lens, NodeKey, PointChunk, PointNodeId, PointStations, PosedCamera, View,
    ViewProjection, world_from_rig,
};
use glam::{DMat3, DVec2, DVec3, UVec2, Vec3};

use super::reference::{Point, disc_depth, disc_normal, drawn_radius, nearest};
use super::{MAX_RADIUS_PX, SplatPass, ViewTarget};
use crate::camera::{NEAR_M, gpu_data::Camera};
use crate::frustum::Frustum;
use crate::kernel_tests::gpu;
use crate::pinhole::Pinhole;
use crate::points::{BLOCK_POINTS, PointStore, Precedence};
use crate::settings::{SplatNormals, SplatRoute};
use crate::targets::Targets;
use crate::tolerances::{DEPTH_M, DISC_BORDER};
use crate::{Gpu, Settings};

mod hard_cases;

const SIZE: UVec2 = UVec2::new(96, 64);
/// Lambert-93.
const CENTRE: DVec3 = DVec3::new(651_187.3, 6_861_353.6, 42.8);

/// Off-centre, unequal focals, turned every way.
fn camera(centre: DVec3) -> PosedCamera {
    let rig = world_from_rig(0.7, 0.2, 0.1).transpose();
    let cam_from_rig = DMat3::from_cols_array(&[1., 0., 0., 0., 0., 1., 0., -1., 0.]);
    let intrinsics = Intrinsics { fx: 80.0, fy: 74.0, cx: 51.0, cy: 29.5 };
    PosedCamera {
        centre,
        cam_from_world: cam_from_rig * rig,
        lens: Lens::pinhole(SIZE, intrinsics),
    }
}

/// Points given in the camera's frame with their normals, zero where they have none.
fn chunk(camera: &PosedCamera, points: &[(DVec3, DVec3)], spacing_m: f32) -> PointChunk {
    let origin = camera.centre.floor();
    let world_from_cam = camera.cam_from_world.transpose();
    let position = |p: DVec3| (camera.centre - origin + world_from_cam * p).as_vec3();
    PointChunk {
        id: PointNodeId { source: 0, key: NodeKey::ROOT },
        origin,
        positions: points.iter().map(|&(p, _)| position(p).to_array()).collect(),
        colours: Vec::new(),
        intensities: Vec::new(),
        classes: Vec::new(),
        normals: points.iter().map(|&(_, n)| (world_from_cam * n).as_vec3().to_array()).collect(),
        stations: PointStations::default(),
        spacing_m,
        spacings_m: Vec::new(),
    }
}

/// What the device shows of a chunk: bits of depth, and index, of each pixel.
fn drawn(
    gpu: &Gpu,
    camera: &PosedCamera,
    chunk: &PointChunk,
    way: Way,
    normals: SplatNormals,
) -> Vec<(u32, u32)> {
    let view = View { camera: *camera, projection: ViewProjection::Perspective };
    drawn_in(gpu, &view, chunk, way, normals)
}

/// The same for any view.
fn drawn_in(
    gpu: &Gpu,
    view: &View,
    chunk: &PointChunk,
    way: Way,
    normals: SplatNormals,
) -> Vec<(u32, u32)> {
    let camera = &view.camera;
    let settings = Settings {
        splat_route: way.route,
        quads_from_px: Some(way.quads_from_px),
        splat_normals: normals,
        ..Settings::default()
    };
    let pinhole = Pinhole::for_view(&camera.lens, 4096, 1 << 20).expect("a pinhole");
    let mut store = PointStore::new(normals);
    store.insert(gpu, &settings, chunk, glam::DVec3::ZERO).expect("good points");
    store.upload(gpu);
    let list =
        store.view_list(&Frustum::of_view(view, &pinhole), camera.centre, 1.0, Precedence::View);
    let pass = SplatPass::new(gpu, &settings);
    let route = pass.route(gpu, u64::from(SIZE.x * SIZE.y));
    let targets = Targets::new(gpu, SIZE, SIZE, route);
    let target = ViewTarget {
        nearest: &targets.nearest_points,
        winners: &targets.winners,
        winning_normals: &targets.winning_normals,
        canvas: &targets.canvas,
    };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let data = Camera::of_view(view, &pinhole);
    pass.draw_view(gpu, &mut encoder, &store, &list, &data, target);
    gpu.queue.submit([encoder.finish()]);
    targets.nearest_points.pairs(gpu)
}

/// How the same picture comes about.
#[derive(Clone, Copy, Debug)]
struct Way {
    route: SplatRoute,
    quads_from_px: u32,
}

/// The ways that the device has, from no quads to nothing else; says what it lacks.
fn ways() -> Vec<Way> {
    let mut routes = vec![SplatRoute::Atomic32];
    if gpu().has_64_bit_atomics() {
        routes.push(SplatRoute::Atomic64);
    } else {
        println!("skipped: {} has no atomics of 64 bits", gpu().adapter_name());
    }
    let quads = [u32::MAX, 12, 0];
    let with = |route| quads.map(|quads_from_px| Way { route, quads_from_px });
    routes.into_iter().flat_map(with).collect()
}

/// The points of a chunk as the reference takes them, with the radius that the store gives
/// them; those that are not drawn have none.
fn reference_points(
    camera: &PosedCamera,
    pinhole: &Pinhole,
    chunk: &PointChunk,
    normals: SplatNormals,
) -> Vec<Point> {
    let settings = Settings::default();
    let exact = settings.splat_radius_m(chunk.spacing_m) / 0.001;
    // One of the codes of points/record.rs.
    let stored_m = 0.001 * f64::from((8.0 * exact.log2()).round().max(1.0) * 0.125).exp2();
    chunk
        .positions
        .iter()
        .zip(&chunk.normals)
        .map(|(&p, &n)| {
            let position = camera.cam_from_world(chunk.origin + Vec3::from_array(p).as_dvec3());
            let normal = camera.cam_from_world * Vec3::from_array(n).as_dvec3();
            let drawn = position.z >= f64::from(NEAR_M);
            Point {
                position,
                normal: if normals == SplatNormals::Eye { DVec3::ZERO } else { normal },
                radius_m: if drawn {
                    let focal_px = pinhole.focal.min_element();
                    drawn_radius(stored_m, position, focal_px, MAX_RADIUS_PX)
                } else {
                    0.0
                },
            }
        })
        .collect()
}

/// How many pixels were compared and covered, and how many the border of a disc leaves open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Compared {
    covered: usize,
    undecided: usize,
}

/// Holds what the device shows of a chunk, by every way, against the reference.
fn compare(camera: &PosedCamera, chunk: &PointChunk, normals: SplatNormals) -> Compared {
    let pinhole = Pinhole::for_view(&camera.lens, 4096, 1 << 20).expect("a pinhole");
    let points = reference_points(camera, &pinhole, chunk, normals);
    let scaled = |scale: f64| -> Vec<Point> {
        points.iter().map(|point| Point { radius_m: point.radius_m * scale, ..*point }).collect()
    };
    let (inner, outer) = (scaled(1.0 - DISC_BORDER), scaled(1.0 + DISC_BORDER));
    let shown: Vec<_> =
        ways().into_iter().map(|way| drawn(gpu(), camera, chunk, way, normals)).collect();
    for (other, way) in shown.iter().zip(ways()) {
        assert!(shown[0] == *other, "{way:?} differs");
    }
    let mut compared = Compared { covered: 0, undecided: 0 };
    for (i, (depth, index)) in shown[0].iter().copied().enumerate() {
        let (x, y) = (i as u32 % SIZE.x, i as u32 / SIZE.x);
        let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let at = |points: &[Point]| nearest(points, pinhole.focal, pinhole.centre, pixel);
        let expected = at(&points);
        let which = |points: &[Point]| at(points).map(|shown| shown.index);
        if which(&inner) != which(&outer) {
            compared.undecided += 1;
            continue;
        }
        match expected {
            None => assert_eq!(index, u32::MAX, "nothing at {pixel}"),
            Some(expected) => {
                compared.covered += 1;
                let found = f64::from(f32::from_bits(depth));
                let off = (found - expected.depth_m).abs();
                assert!(off < DEPTH_M, "{pixel}: {found} m, point {index}, for {expected:?}");
                // Discs of one plane are equally near: f32 and f64 may choose differently.
                let direction = ((pixel - pinhole.centre) / pinhole.focal).extend(1.0);
                let chosen = disc_depth(&outer[index as usize], direction);
                let as_near = chosen.is_some_and(|z| (z - expected.depth_m).abs() < DEPTH_M);
                assert!(as_near, "{pixel}: {chosen:?} of point {index} for {expected:?}");
            }
        }
    }
    compared
}

/// Points before, behind, beside and on the plane of the camera, 0.1 to 80 m away, with
/// normals in every direction and some without.
fn everywhere() -> Vec<(DVec3, DVec3)> {
    (0..900u32)
        .map(|i| {
            let sequence = |step: f64| ((f64::from(i) + 0.5) * step).fract();
            let z = 80.0 * sequence(0.618_034).powi(2) * if i % 9 == 0 { -1.0 } else { 1.0 };
            let m = DVec2::new(sequence(0.754_878) - 0.5, sequence(0.569_84) - 0.5) * 2.2;
            let p = DVec3::new(m.x * z, m.y * z, if i % 31 == 0 { 0.0 } else { z });
            let n = [0.41, 0.23, 0.87].map(|step| 2.0 * sequence(step + 0.001) - 1.0);
            let n = if i % 5 == 0 { DVec3::ZERO } else { DVec3::from_array(n).normalize() };
            (p, n)
        })
        .collect()
}

#[test]
fn depths_and_winners_agree_with_the_reference() {
    let camera = camera(CENTRE);
    for normals in [SplatNormals::Eye, SplatNormals::Estimated] {
        for spacing_m in [0.02f32, 0.3] {
            let compared = compare(&camera, &chunk(&camera, &everywhere(), spacing_m), normals);
            assert!(compared.covered > 300 && compared.undecided < 60, "{compared:?}");
        }
    }
}

/// Rays parallel to the axis: a pixel at m, metres from it, sees (m, z), and discs without a
/// normal face along the axis.
#[test]
fn views_without_perspective_agree_with_the_reference() {
    let mut posed = camera(CENTRE);
    let focal_px = 4.0;
    posed.lens = Lens::pinhole(SIZE, Intrinsics { fx: 4.0, fy: 4.0, cx: 51.0, cy: 29.5 });
    let view = View { camera: posed, projection: ViewProjection::Orthographic };
    let points: Vec<_> = everywhere()
        .into_iter()
        .map(|(p, n)| (DVec3::new(0.15 * p.x, 0.15 * p.y, p.z), n))
        // On the plane of the eye rounding decides.
        .filter(|(p, _)| p.z.abs() > 1e-3)
        .collect();
    let points = chunk(&posed, &points, 0.5);
    for normals in [SplatNormals::Eye, SplatNormals::Estimated] {
        let shown: Vec<_> =
            ways().into_iter().map(|way| drawn_in(gpu(), &view, &points, way, normals)).collect();
        for (other, way) in shown.iter().zip(ways()) {
            assert!(shown[0] == *other, "{way:?} differs");
        }
        // The largest radius of a splat, 0.25 m, is one of the codes to within 4.5 %.
        let radius_m = 0.001 * f64::from((8.0 * 250f32.log2()).round() * 0.125).exp2();
        let depth = |index: usize, scale: f64, m: DVec2| {
            let world = points.origin + Vec3::from_array(points.positions[index]).as_dvec3();
            let p = posed.cam_from_world(world);
            let n = posed.cam_from_world * Vec3::from_array(points.normals[index]).as_dvec3();
            let n = if normals == SplatNormals::Eye { DVec3::ZERO } else { n };
            let plane = disc_normal(DVec3::Z, n);
            let z = p.z - plane.truncate().dot(m - p.truncate()) / plane.z;
            let reaches = (m.extend(z) - p).length() <= radius_m * scale;
            (p.z > 0.0 && reaches && z > 0.0).then_some(z)
        };
        let (mut covered, mut undecided) = (0, 0);
        for (i, &(bits, index)) in shown[0].iter().enumerate() {
            let pixel = DVec2::new((i as u32 % SIZE.x).into(), (i as u32 / SIZE.x).into()) + 0.5;
            let m = (pixel - DVec2::new(51.0, 29.5)) / focal_px;
            let nearest = |scale: f64| {
                (0..points.positions.len())
                    .filter_map(|index| Some((depth(index, scale, m)?, index)))
                    .min_by(|a, b| a.0.total_cmp(&b.0))
            };
            let (inner, outer) = (nearest(1.0 - DISC_BORDER), nearest(1.0 + DISC_BORDER));
            if inner.map(|(_, index)| index) != outer.map(|(_, index)| index) {
                undecided += 1;
                continue;
            }
            match outer {
                None => assert_eq!(index, u32::MAX, "nothing at {pixel}"),
                Some((z, expected)) => {
                    covered += 1;
                    assert_eq!(index as usize, expected, "{pixel}");
                    let off = (f64::from(f32::from_bits(bits)) - z).abs();
                    assert!(off < DEPTH_M, "{pixel}: {off} m off, point {index}");
                }
            }
        }
        assert!(covered > 300 && undecided < 60, "{covered} covered, {undecided} undecided");
    }
}

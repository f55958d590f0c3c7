//! The splat pass against a reference that tries every point at every pixel.

use flaneur_scene::{
    Intrinsics, Lens, NodeKey, PointChunk, PointNodeId, PosedCamera, world_from_rig,
};
use glam::{DMat3, DVec2, DVec3, UVec2};

use super::reference::nearest;
use super::{MAX_RADIUS_PX, MIN_RADIUS_PX, SplatPass, ViewTarget};
use crate::Settings;
use crate::camera::{NEAR_M, gpu_data::Camera};
use crate::frustum::Frustum;
use crate::kernel_tests::{gpu, read};
use crate::pinhole::Pinhole;
use crate::points::PointStore;
use crate::tolerances::{DEPTH_M, DISC_BORDER};

const SIZE: UVec2 = UVec2::new(96, 64);

/// Off-centre, unequal focals, turned every way, at Lambert-93 coordinates.
fn camera() -> PosedCamera {
    let rig = world_from_rig(0.7, 0.2, 0.1).transpose();
    let cam_from_rig = DMat3::from_cols_array(&[1., 0., 0., 0., 0., 1., 0., -1., 0.]);
    let intrinsics = Intrinsics { fx: 80.0, fy: 74.0, cx: 51.0, cy: 29.5 };
    PosedCamera {
        centre: DVec3::new(651_187.3, 6_861_353.6, 42.8),
        cam_from_world: cam_from_rig * rig,
        lens: Lens::pinhole(SIZE, intrinsics),
    }
}

/// Points before, behind, beside and on the plane of the camera, 0.1 to 80 m away.
fn chunk(camera: &PosedCamera, spacing_m: f32) -> PointChunk {
    let origin = camera.centre.floor();
    let positions = (0..900u32)
        .map(|i| {
            let sequence = |step: f64| ((f64::from(i) + 0.5) * step).fract();
            let z = 80.0 * sequence(0.618_034).powi(2) * if i % 9 == 0 { -1.0 } else { 1.0 };
            let m = DVec2::new(sequence(0.754_878) - 0.5, sequence(0.569_84) - 0.5) * 2.2;
            let p_cam = DVec3::new(m.x * z, m.y * z, if i % 31 == 0 { 0.0 } else { z });
            let world = camera.centre + camera.cam_from_world.transpose() * p_cam;
            (world - origin).as_vec3().to_array()
        })
        .collect();
    PointChunk {
        id: PointNodeId { source: 0, key: NodeKey::ROOT },
        origin,
        positions,
        colours: Vec::new(),
        intensities: Vec::new(),
        classes: Vec::new(),
        normals: Vec::new(),
        spacing_m,
    }
}

/// The radius that the pass gives a point, from its documentation: the stored radius, at
/// least what covers a pixel, at most what bounds the loop.
fn radius(stored_m: f64, p: DVec3, focal: DVec2) -> f64 {
    let pixel_m = p.z / focal.min_element();
    let off_axis = p.length() / p.z;
    stored_m
        .max(f64::from(MIN_RADIUS_PX) * pixel_m)
        .min(f64::from(MAX_RADIUS_PX) * pixel_m / off_axis)
}

#[test]
fn depths_and_winners_agree_with_the_reference() {
    for spacing_m in [0.02f32, 0.3] {
        let camera = camera();
        let pinhole = Pinhole::for_view(&camera.lens, 4096, 1 << 20).expect("a pinhole");
        let chunk = chunk(&camera, spacing_m);
        let settings = Settings::default();
        let mut store = PointStore::default();
        store.insert(gpu(), &settings, &chunk).expect("good points");
        store.upload(gpu());
        let list = store.view_list(&Frustum::new(&camera, &pinhole), camera.centre);
        let buffer = || {
            gpu().device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: u64::from(SIZE.x * SIZE.y * 4),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let (depths, indices) = (buffer(), buffer());
        let targets = crate::targets::Targets::new(gpu(), SIZE, SIZE);
        let target = ViewTarget { depths: &depths, indices: &indices, winners: &targets.winners };
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let data = Camera::new(&camera, &pinhole);
        SplatPass::new(gpu()).draw_view(gpu(), &mut encoder, &store, &list, &data, target);
        let depths: Vec<u32> = read(encoder, &depths);
        let encoder = gpu().device.create_command_encoder(&Default::default());
        let indices: Vec<u32> = read(encoder, &indices);

        // The stored radius is one of the codes of points/record.rs.
        let exact = (spacing_m * settings.splat_scale).min(settings.max_splat_radius_m) / 0.001;
        let stored_m = 0.001 * f64::from((8.0 * exact.log2()).round() * 0.125).exp2();
        let points: Vec<(DVec3, f64)> = chunk
            .positions
            .iter()
            .map(|&p| {
                let world = chunk.origin + glam::Vec3::from_array(p).as_dvec3();
                let p = camera.cam_from_world(world);
                let drawn = p.z >= f64::from(NEAR_M);
                (p, if drawn { radius(stored_m, p, pinhole.focal) } else { 0.0 })
            })
            .collect();
        let (mut covered, mut undecided) = (0, 0);
        for (i, (depth, index)) in depths.into_iter().zip(indices).enumerate() {
            let (x, y) = (i as u32 % SIZE.x, i as u32 / SIZE.x);
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let at = |scale: f64| {
                let scaled: Vec<_> = points.iter().map(|&(p, r)| (p, r * scale)).collect();
                nearest(&scaled, pinhole.focal, pinhole.centre, pixel)
            };
            let (inner, expected, outer) = (at(1.0 - DISC_BORDER), at(1.0), at(1.0 + DISC_BORDER));
            let which = |n: &Option<super::reference::Nearest>| n.map(|n| n.index);
            if which(&inner) != which(&outer) {
                undecided += 1;
                continue;
            }
            match expected {
                None => assert_eq!(index, u32::MAX, "nothing at {pixel}"),
                Some(expected) => {
                    covered += 1;
                    let found = f64::from(f32::from_bits(depth));
                    let off = (found - expected.depth_m).abs();
                    assert!(off < DEPTH_M, "{pixel}: {found} m for {expected:?}");
                    assert_eq!(index as usize, expected.index, "{pixel}: {expected:?}");
                }
            }
        }
        assert!(covered > 300 && undecided < 60, "{covered} covered, {undecided} undecided");
    }
}

//! The G-buffer's planes against rays and planes in f64.

use flaneur_scene::{MeshTile, MeshVertex, PosedCamera, SurfaceClass, TileKey, TileLayer, View};
use glam::{DVec3, UVec2, Vec3};

use super::reference::plane_depth;
use super::{MeshPass, MeshStore, PLANE_FORMAT};
use crate::camera::gpu_data::Camera;
use crate::frustum::Frustum;
use crate::kernel_tests::{gpu, read};
use crate::pinhole::Pinhole;
use crate::targets::Targets;
use crate::tolerances::DEPTH_M;

const SIZE: UVec2 = UVec2::new(64, 48);

/// A large triangle through `centre` with normal `n`, in a tile whose origin is elsewhere.
fn tile(centre: DVec3, n: DVec3) -> MeshTile {
    let origin = centre.floor() - DVec3::new(120.0, -75.0, 30.0);
    let (u, v) = n.any_orthonormal_pair();
    let corner = |angle: f64| {
        let p = centre + (u * angle.cos() + v * angle.sin()) * 200.0;
        MeshVertex {
            position: (p - origin).as_vec3().to_array(),
            normal: n.as_vec3().to_array(),
            uncertainty_m: 0.5,
            class: SurfaceClass::Wall,
        }
    };
    MeshTile {
        key: TileKey { layer: TileLayer::Footprints, x: 0, y: 0 },
        origin,
        vertices: vec![corner(0.0), corner(2.1), corner(4.2)],
        indices: vec![0, 1, 2],
    }
}

/// The planes that the device draws, relative to the eye.
fn planes(tile: &MeshTile, camera: &PosedCamera) -> Vec<[f32; 4]> {
    let gpu = gpu();
    let pinhole = Pinhole::for_view(&camera.lens, 4096, 1 << 20).expect("a pinhole");
    let mut store = MeshStore::default();
    store.insert(gpu, tile, u64::MAX, glam::DVec3::ZERO, &mut Vec::new()).expect("a good tile");
    let list = store.draw_list(gpu, &Frustum::new(camera, &pinhole), camera.centre);
    let targets = Targets::new(gpu, SIZE, SIZE, crate::splat::Route::Atomic32);
    let extent = wgpu::Extent3d { width: SIZE.x, height: SIZE.y, depth_or_array_layers: 1 };
    let planes = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: PLANE_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    MeshPass::new(gpu).draw_gbuffer(
        gpu,
        &mut encoder,
        &Camera::new(camera, &pinhole),
        &list,
        false,
        &planes.create_view(&Default::default()),
        &targets.surfaces,
        &targets.depth,
    );
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIZE.x * SIZE.y * 16),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    encoder.copy_texture_to_buffer(
        planes.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(16 * SIZE.x),
                rows_per_image: None,
            },
        },
        extent,
    );
    read(encoder, &buffer)
}

#[test]
fn depths_are_good_to_a_millimetre_at_fifty_metres() {
    for origin in [DVec3::ZERO, DVec3::new(651_187.3, 6_861_353.6, 42.8), DVec3::splat(1e8)] {
        let view = View::look(origin, 0.6, 0.1, 0.7, SIZE);
        let forward = view.camera.forward();
        // From facing to 80° aslant.
        for slant in [0.0f64, 0.8, 1.4] {
            let aside = forward.cross(DVec3::Z).normalize();
            let n = -forward * slant.cos() + aside * slant.sin();
            let centre = origin + forward * 40.0;
            let tile = tile(centre, n);
            // The plane of the vertices as they are stored: rounding them is not the pass's.
            let corner = |i: usize| {
                tile.origin - origin + Vec3::from_array(tile.vertices[i].position).as_dvec3()
            };
            let normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalize();
            let mut compared = 0;
            for (i, plane) in planes(&tile, &view.camera).into_iter().enumerate() {
                let pixel = DVec3::new(
                    f64::from(i as u32 % SIZE.x) + 0.5,
                    f64::from(i as u32 / SIZE.x) + 0.5,
                    0.0,
                );
                let ray = view.camera.lens.unproject(pixel.truncate()).expect("a pinhole");
                let world = view.camera.cam_from_world.transpose() * ray;
                let Some(expected) = plane_depth(normal, normal.dot(corner(0)), world) else {
                    continue;
                };
                if plane == [0.0; 4] || expected > 60.0 {
                    continue;
                }
                let n = Vec3::new(plane[0], plane[1], plane[2]).as_dvec3();
                let found = plane_depth(n, f64::from(plane[3]), world).expect("in front");
                let off = (found - expected).abs();
                compared += 1;
                assert!(off < DEPTH_M, "{origin} {slant} {pixel}: {found} for {expected} m");
            }
            assert!(compared > 500, "{origin} {slant}: {compared}");
        }
    }
}

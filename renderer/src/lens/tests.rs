//! The device's lens against `flaneur_scene::Lens`, which is f64 and tested on its own.

use flaneur_scene::{Distortion, Intrinsics, Lens, PosedCamera, View};
use glam::{DVec2, DVec3, UVec2};

use super::{NOWHERE, gpu_data, undistortion_grid};
use crate::kernel_tests::{gpu, places, run};
use crate::tolerances::{FISHEYE_PX, LENS_PX};
use crate::{Renderer, Settings};

const KERNEL: &str = "
@group(0) @binding(0) var<storage, read> lens: array<Lens>;
@group(0) @binding(1) var<storage, read> position: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read_write> pixel: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&position) {
        pixel[id.x] = vec4(lens_pixel(lens[0], position[id.x]), 0.0);
    }
}";

/// Lenses without symmetry: off-centre, unequal focals, one for each model.
fn lenses() -> Vec<Lens> {
    let size = UVec2::new(2048, 1536);
    let intrinsics = Intrinsics { fx: 1150.7, fy: 1141.3, cx: 1030.3, cy: 770.9 };
    [
        Distortion::None,
        Distortion::RadialPixels {
            centre: DVec2::new(1042.2, 760.6),
            k: [-1.338e-7, 3.475e-14, -4.441e-21],
            limit_px: 2079.0,
        },
        Distortion::Brown { k: [-0.28, 0.07, -0.004], p: [0.003, -0.002] },
        Distortion::Brown { k: [-1.0, 0.0, 0.0], p: [0.0, 0.0] },
        Distortion::Fisheye { k: [-0.02, 0.004, -0.001, 0.0002] },
    ]
    .map(|distortion| Lens { size, intrinsics, distortion })
    .into()
}

#[test]
fn pixels_agree_with_the_reference_up_to_the_limit() {
    let positions: Vec<[f32; 2]> = (0..101 * 101)
        .map(|i| [(i % 101) as f32 * 0.04 - 2.0, (i / 101) as f32 * 0.03 - 1.5])
        .collect();
    for lens in lenses() {
        let data = gpu_data::Lens::new(&lens);
        let fisheye = matches!(lens.distortion, Distortion::Fisheye { .. });
        let allowed = if fisheye { FISHEYE_PX } else { LENS_PX };
        let found: Vec<[f32; 4]> = run(
            &[super::WGSL, KERNEL].concat(),
            &[bytemuck::bytes_of(&data), bytemuck::cast_slice(&positions)],
            positions.len(),
            positions.len(),
        );
        let mut compared = 0;
        for (position, found) in positions.iter().zip(found) {
            let m = DVec2::new(f64::from(position[0]), f64::from(position[1]));
            // Not within rounding of the limit, where either answer is right.
            let (inner, outer) = (m * (1.0 - 1e-4), m * (1.0 + 1e-4));
            let expected = lens.distorted_from_normalised(m);
            let decided = lens.distorted_from_normalised(inner).is_some()
                == lens.distorted_from_normalised(outer).is_some();
            if !decided {
                continue;
            }
            assert_eq!(found[2] == 1.0, expected.is_some(), "{lens:?} at {m}");
            let Some(expected) = expected else { continue };
            let pixel = DVec2::new(f64::from(found[0]), f64::from(found[1]));
            if lens.contains(expected) {
                compared += 1;
                let off = pixel.distance(expected);
                assert!(off < allowed, "{lens:?} at {m}: {pixel} for {expected}, off {off} px");
            }
        }
        assert!(compared > 500, "{lens:?}: {compared}");
    }
}

#[test]
fn the_grid_holds_the_inverse_of_the_lens() {
    let lens = lenses()[1];
    let grid = undistortion_grid(&lens);
    let columns = super::grid_size(lens.size).x;
    for (i, node) in (0..).zip(&grid) {
        let pixel = UVec2::new(i % columns, i / columns) * super::GRID_STEP;
        if node[0] < NOWHERE {
            let m = DVec2::new(f64::from(node[0]), f64::from(node[1]));
            let back = lens.distorted_from_normalised(m).expect("within the limit");
            assert!(back.distance(pixel.as_dvec2()) < LENS_PX, "{pixel} {back}");
        }
    }
    assert!(grid.iter().filter(|node| node[0] < NOWHERE).count() * 10 > grid.len() * 9);
}

/// Every pixel of a view looks where the lens, in f64, projects back onto its centre. The pixels of a
/// view of nothing keep that direction.
#[test]
fn pixels_of_a_view_look_where_the_lens_sees_them() {
    let mut renderer =
        Renderer::with_settings(gpu(), Settings { infer: false, ..Settings::default() });
    for lens in lenses() {
        let size = UVec2::new(lens.size.x / 4, lens.size.y / 4);
        let lens = lens.scaled_to(size);
        let pose = View::look(DVec3::new(3.0, -2.0, 1.5), 0.7, -0.2, 1.0, size).camera;
        let camera = PosedCamera { lens, ..pose };
        renderer.render(&View::from(camera)).expect("a frame");
        let fisheye = matches!(lens.distortion, Distortion::Fisheye { .. });
        let allowed = if fisheye { FISHEYE_PX } else { LENS_PX };
        let (mut looks, mut largest) = (0, 0.0f64);
        let rays = places(renderer.last_positions().expect("a frame"), size);
        for ((ray, shows), i) in rays.into_iter().zip(0..) {
            assert!(!shows);
            if ray == DVec3::ZERO {
                continue;
            }
            looks += 1;
            let pixel = UVec2::new(i % size.x, i / size.x).as_dvec2() + 0.5;
            let back = lens.project(camera.cam_from_world * ray).expect("within the limit");
            largest = largest.max(back.distance(pixel));
        }
        println!("{:?}: {looks} pixels, off by up to {largest} px", lens.distortion);
        assert!(largest < allowed, "{lens:?}: {largest} px");
        let reached = (0..size.element_product()).filter(|i| {
            let pixel = UVec2::new(i % size.x, i / size.x).as_dvec2() + 0.5;
            lens.unproject(pixel).is_some()
        });
        let reached = reached.count();
        assert!(looks * 10 > reached * 9 && looks > 10_000, "{looks} of {reached}");
    }
}

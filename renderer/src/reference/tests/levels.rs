//! The levels of detail of a photograph on the device against f64.

use flaneur_scene::{ImageUpdate, PosedCamera, View};
use glam::{DVec3, UVec2};
use wgpu::BindingResource::TextureView as Texture;

use crate::kernel_tests::channels::{Channels, draw};
use crate::kernel_tests::gpu;
use crate::photographs::atlas::{Atlas, MAX_LOD, Place};
use crate::reference::pyramid::Pyramid;
use crate::screen::{WHOLE_WGSL, screen_pass_with};
use crate::tolerances::{BYTE_255, HALVED_255, HALVED_MASK_255};

/// Texels as shaders read them.
const LOAD: &str = "
override LAYER: i32;
override X: i32;
override Y: i32;
@group(0) @binding(0) var atlas: texture_2d_array<u32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return unpack4x8unorm(textureLoad(atlas, vec2(X, Y) + vec2<i32>(at.xy), LAYER, 0).x);
}";

fn level_on_device(atlas: &Atlas, place: Place, level: usize, size: UVec2) -> Vec<[f32; 4]> {
    let corner = place.level_corner(level as u32);
    let constants = [("LAYER", place.layer.into()), ("X", corner.x.into()), ("Y", corner.y.into())];
    let format = wgpu::TextureFormat::Rgba32Float;
    let source = [WHOLE_WGSL, LOAD].concat();
    let pass = screen_pass_with(gpu(), "load", &source, &[format], &constants);
    let found = Channels::<4>::new(size);
    draw(&pass, vec![Texture(&atlas.views()[place.array])], &found.view());
    found.read().values
}

/// Odd sizes, a photograph that does not lie in its layer's corner, every byte, and a mask.
#[test]
fn levels_agree_with_their_reference() {
    let size = UVec2::new(301, 211);
    let camera = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, size).camera;
    let byte = |i: u32, by: u32| (i.wrapping_mul(by) >> 7) as u8;
    let masked =
        |x: u32, y: u32| UVec2::new(x, y).as_vec2().distance(glam::vec2(80.0, 60.0)) < 30.0;
    let rgba = (0..size.element_product())
        .flat_map(|i| {
            let mask = if masked(i % size.x, i / size.x) { 0 } else { 128 + byte(i, 77) / 2 };
            // Smooth, coarse, and all that there is.
            [(i % 256) as u8, byte(i, 7919), (i / size.x) as u8, mask]
        })
        .collect();
    let image = ImageUpdate {
        id: "a/x".parse().expect("a name"),
        level: 0,
        camera: PosedCamera { ..camera },
        size,
        rgba,
        uncertainty_m: 0.0,
    };
    let mut atlas = Atlas::new(gpu());
    atlas.insert(gpu(), size, &image.rgba, u64::MAX).expect("room");
    let place = atlas.insert(gpu(), size, &image.rgba, u64::MAX).expect("room");
    assert_ne!(place.corner, UVec2::ZERO);
    let pyramid = Pyramid::new(&image);
    for level in 0..=MAX_LOD as usize {
        let (size, expected) = pyramid.level(level);
        let found = level_on_device(&atlas, place, level, size);
        assert_eq!(found.len(), expected.len());
        let (mut off, mut mask_off, mut hidden) = (0.0f64, 0.0f64, 0);
        for (found, (colour, mask)) in found.iter().zip(expected) {
            let [r, g, b, a] = found.map(f64::from);
            // Nobody asks for the colour of a texel that is hidden.
            if *mask > 0.0 {
                off = off.max((DVec3::new(r, g, b) - colour).abs().max_element() * 255.0);
            } else {
                hidden += 1;
            }
            assert_eq!(a > 0.0, *mask > 0.0, "level {level}");
            mask_off = mask_off.max((a - mask).abs() * 255.0);
        }
        println!("level {level}: off by {off}, mask by {mask_off}, {hidden} hidden");
        let halved = level as f64;
        assert!(off <= BYTE_255 + HALVED_255 * halved, "level {level}: {off}");
        assert!(mask_off <= HALVED_MASK_255 * halved + BYTE_255, "level {level}: {mask_off}");
        assert!(hidden > 0);
    }
}

//! Push and pull on the device against its reference.

use glam::{DVec3, DVec4, UVec2};

use super::reference::{Known, diffused, near};
use super::{DiffusePass, Layers, Levels};
use crate::kernel_tests::channels::{Channels, copy, texels};
use crate::kernel_tests::{gpu, noise};
use crate::layers::one_layer;
use crate::reference::field::Field;
use crate::tolerances::DIFFUSION_RELATIVE;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const OTHERWISE: [f32; 3] = [0.0025, 7.0, 0.5];

/// Values from 0.02 to 0.5, known in a share of the cells.
fn known(size: UVec2, share: f32, seed: u32) -> Field<[f32; 4]> {
    Field::new(size, |cell| {
        let value = |channel| 0.02 + 0.48 * noise(cell, seed + channel);
        match noise(cell, seed) < share {
            true => [value(1), value(2), value(3), 1.0],
            false => [0.0; 4],
        }
    })
}

/// What the device makes of what is known of each layer.
fn on_device(layers: Layers, known: &[Field<[f32; 4]>]) -> Vec<Field<[f32; 4]>> {
    let pass = DiffusePass::new(gpu(), FORMAT);
    let levels = Levels::new(gpu(), known[0].size, layers, FORMAT);
    for (known, layer) in known.iter().zip(levels.known_layers()) {
        copy(&Channels::holding(known).view(), layer);
    }
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    pass.draw(gpu(), &mut encoder, &levels, OTHERWISE);
    gpu().queue.submit([encoder.finish()]);
    let texture = levels.diffused().texture();
    (0..layers.count()).map(|layer| texels(&one_layer(texture, layer))).collect()
}

/// What it makes whole of `known`.
fn whole_on_device(known: &Field<[f32; 4]>) -> Field<[f32; 4]> {
    let layers = Layers { whole: 1, near: 0 };
    on_device(layers, std::slice::from_ref(known)).remove(0)
}

fn in_f64(known: &Field<[f32; 4]>) -> Field<Known<DVec3>> {
    known.each(|known| {
        let [x, y, z, weight] = known.map(f64::from);
        Known { value: DVec3::new(x, y, z), weight }
    })
}

#[test]
fn diffusion_agrees_with_its_reference() {
    let sizes = [(1, 1), (2, 1), (7, 5), (16, 16), (33, 18), (50, 3)].map(UVec2::from);
    for (seed, size) in (0..).zip(sizes) {
        for share in [0.0, 0.02, 0.3, 1.0] {
            let known = known(size, share, 10 * seed);
            let found = whole_on_device(&known);
            let any = known.values.iter().any(|[.., weight]| *weight > 0.0);
            let otherwise = DVec3::from_array(OTHERWISE.map(f64::from));
            let expected = diffused(&in_f64(&known), otherwise);
            for (found, expected) in found.values.iter().zip(expected.values) {
                let [x, y, z, weight] = found.map(f64::from);
                let off = (DVec3::new(x, y, z) / expected - 1.0).abs().max_element();
                assert!(off < DIFFUSION_RELATIVE, "{found:?} for {expected}, {size}, {share}");
                let expected = if any { 1.0 } else { 0.0 };
                assert!((weight - expected).abs() < DIFFUSION_RELATIVE, "{weight}");
            }
        }
    }
}

/// Beside others, whose values it does not take.
#[test]
fn what_stays_near_agrees_with_its_reference() {
    let layers = Layers { whole: 1, near: 2 };
    for size in [(1, 1), (7, 5), (16, 16), (50, 33), (3, 90)].map(UVec2::from) {
        for share in [0.0, 0.004, 0.3, 1.0] {
            let known = [1, 40, 80].map(|seed| known(size, share, seed));
            let found = on_device(layers, &known);
            let (mut none, mut partly) = (0, 0);
            for (found, known) in found.iter().zip(&known).skip(1) {
                let (expected, weights) = near(&in_f64(known));
                let expected = expected.values.iter().zip(&weights.values);
                for (found, (expected, weight)) in found.values.iter().zip(expected) {
                    let off = DVec4::from_array(found.map(f64::from)) - expected.extend(*weight);
                    let off = off.abs().max_element();
                    assert!(off < DIFFUSION_RELATIVE, "{found:?} for {expected}, {size}, {share}");
                    none += u32::from(*weight == 0.0);
                    partly += u32::from(*weight > 0.0 && *weight < 1.0);
                }
            }
            println!("{size}, {share}: {none} not, {partly} partly");
            let far = share == 0.004 && size.element_product() > 200;
            assert!(!far || (none > 20 && partly > 20), "{none} not, {partly} partly of {size}");
        }
    }
}

#[test]
fn diffusion_keeps_what_is_known_and_stays_within_it() {
    let known = known(UVec2::new(21, 14), 0.1, 3);
    let whole = whole_on_device(&known);
    for channel in 0..3 {
        let some = known.values.iter().filter(|[.., weight]| *weight > 0.0).map(|v| v[channel]);
        let (least, most) = some.fold((f32::MAX, 0.0f32), |(a, b), v| (a.min(v), b.max(v)));
        assert!(least < most);
        for (known, whole) in known.values.iter().zip(&whole.values) {
            let (value, whole) = (known[channel], whole[channel]);
            assert!(known[3] == 0.0 || value == whole, "{whole} for {value}");
            let whole = f64::from(whole);
            let (low, high) = (1.0 - DIFFUSION_RELATIVE, 1.0 + DIFFUSION_RELATIVE);
            let (least, most) = (low * f64::from(least), high * f64::from(most));
            assert!(least <= whole && whole <= most, "{least} {whole} {most}");
        }
    }
}

#[test]
fn bytes_are_known_before_they_are_taken() {
    for size in [(1, 1), (33, 18), (256, 128)].map(UVec2::from) {
        let layers = Layers { whole: 2, near: 1 };
        let levels = Levels::new(gpu(), size, layers, FORMAT);
        assert_eq!(levels.bytes(), Levels::bytes_for(size, layers, FORMAT), "{size}");
    }
}

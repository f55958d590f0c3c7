//! The passes over the grid on the device against their references.

use glam::UVec2;
use wgpu::BindingResource::TextureView as Texture;

use self::device::{Channels, draw, inference, pass, uniform};
use super::reference::{Field, Known, diffused};
use crate::tolerances::DIFFUSION_RELATIVE;

mod device;

/// Of the backdrop, 1/m.
const BACKDROP: f32 = 0.0025;

/// Any number from 0 to 1, the same for the same cell and seed.
fn noise(cell: UVec2, seed: u32) -> f32 {
    let mut bits = cell.x.wrapping_mul(0x9e37_79b1) ^ cell.y.wrapping_mul(0x85eb_ca77);
    bits = (bits ^ seed.wrapping_mul(0xc2b2_ae3d)).wrapping_mul(0x27d4_eb2f);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297a_2d39);
    ((bits ^ (bits >> 15)) >> 8) as f32 / (1 << 24) as f32
}

/// Inverse ranges from 2 to 50 m, known in a share of the cells.
fn known(size: UVec2, share: f32, seed: u32) -> Field<[f32; 2]> {
    Field::new(size, |cell| match noise(cell, seed) < share {
        true => [0.02 + 0.48 * noise(cell, seed + 1), 1.0],
        false => [0.0; 2],
    })
}

/// What the device makes whole of `known`, level by level.
fn diffused_on_device(known: &Field<[f32; 2]>) -> Field<[f32; 1]> {
    let (pull, top, push) = (pass::<2>("pull", &[]), pass::<1>("top", &[]), pass::<1>("push", &[]));
    let mut levels = vec![Channels::holding(known)];
    let mut size = known.size;
    while size != UVec2::ONE {
        size = (size + 1) / 2;
        let level = Channels::<2>::new(size);
        draw(&pull, vec![Texture(&levels[levels.len() - 1].view())], &level.view());
        levels.push(level);
    }
    let inference = uniform(&inference(known.size, 7, BACKDROP));
    let coarsest = levels.pop().expect("a level");
    let mut whole = Channels::<1>::new(UVec2::ONE);
    draw(&top, vec![inference.as_entire_binding(), Texture(&coarsest.view())], &whole.view());
    while let Some(level) = levels.pop() {
        let next = Channels::<1>::new(level.read().size);
        draw(&push, vec![Texture(&level.view()), Texture(&whole.view())], &next.view());
        whole = next;
    }
    whole.read()
}

#[test]
fn diffusion_agrees_with_its_reference() {
    let sizes = [(1, 1), (2, 1), (7, 5), (16, 16), (33, 18), (50, 3)].map(UVec2::from);
    for (seed, size) in (0..).zip(sizes) {
        for share in [0.0, 0.02, 0.3, 1.0] {
            let known = known(size, share, 10 * seed);
            let found = diffused_on_device(&known);
            let known = Field::new(size, |cell| {
                let [value, weight] = known.at(cell).map(f64::from);
                Known { value, weight }
            });
            let expected = diffused(&known, f64::from(BACKDROP));
            for (&[found], expected) in found.values.iter().zip(expected.values) {
                let off = (f64::from(found) - expected).abs() / expected;
                assert!(off < DIFFUSION_RELATIVE, "{found} for {expected}, {size}, {share}");
            }
        }
    }
}

#[test]
fn diffusion_keeps_what_is_known_and_stays_within_it() {
    let size = UVec2::new(21, 14);
    let known = known(size, 0.1, 3);
    let some = known.values.iter().filter(|[_, weight]| *weight > 0.0);
    let (least, most) = some.fold((f32::MAX, 0.0f32), |(a, b), [v, _]| (a.min(*v), b.max(*v)));
    assert!(least < most);
    let whole = diffused_on_device(&known);
    for (&[value, weight], [whole]) in known.values.iter().zip(whole.values) {
        assert!(weight == 0.0 || value == whole, "{whole} for {value}");
        assert!(least * 0.99999 <= whole && whole <= most * 1.00001, "{least} {whole} {most}");
    }
    let nothing = diffused_on_device(&Field::new(size, |_| [0.0; 2]));
    assert!(nothing.values.iter().all(|&[value]| (value / BACKDROP - 1.0).abs() < 1e-5));
}

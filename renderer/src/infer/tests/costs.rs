//! What the photographs disagree on, and its means.

use glam::UVec2;
use wgpu::BindingResource::TextureView as Texture;

use super::device::{inference, pass};
use super::{BACKDROP, BETWEEN, noise};
use crate::infer::gpu_data;
use crate::infer::reference::{disagreement, window};
use crate::kernel_tests::channels::{Channels, draw, layers, uniform};
use crate::reference::field::{Field, cells};
use crate::tolerances::COST;

const CELLS: UVec2 = UVec2::new(19, 13);
const HYPOTHESES: u32 = BETWEEN + 3;
const RIGS: u32 = 3;

/// The texels that hold a hypothesis: four in one, one such below the other.
fn packed_size() -> UVec2 {
    UVec2::new(CELLS.x, CELLS.y * HYPOTHESES.div_ceil(4))
}

/// One hypothesis of what a pass wrote.
fn unpacked(packed: &Field<[f32; 4]>, index: u32) -> Field<f64> {
    let first = UVec2::new(0, index / 4 * CELLS.y);
    Field::new(CELLS, |cell| f64::from(packed.at(cell + first)[(index % 4) as usize]))
}

#[test]
fn costs_agree_with_their_reference() {
    let tall = UVec2::new(CELLS.x, CELLS.y * HYPOTHESES);
    // Some differ by more than the bound, and a third of the rigs see nothing.
    let seen: Vec<Field<[f32; 2]>> = (0..RIGS)
        .map(|rig| {
            Field::new(tall, |at| {
                let sees = f32::from(u8::from(noise(at, 20 + rig) > 0.33));
                [0.2 * noise(at, 10 + rig), sees]
            })
        })
        .collect();
    let inference = inference(CELLS, BETWEEN, BACKDROP);
    let inference = uniform(&gpu_data::Inference { rigs: RIGS, ..inference });
    let found = Channels::<4>::new(packed_size());
    let sights = layers(&seen);
    let bindings = vec![inference.as_entire_binding(), Texture(&sights)];
    draw(&pass::<4>("cost", &[]), bindings, &found.view());
    let found = found.read();
    for index in 0..HYPOTHESES {
        let found = unpacked(&found, index);
        for cell in cells(CELLS) {
            let at = cell + UVec2::new(0, index * CELLS.y);
            let expected = disagreement(seen.iter().map(|rig| {
                let [brightness, sees] = rig.at(at).map(f64::from);
                (sees > 0.5).then_some(brightness)
            }));
            let found = found.at(cell);
            assert!((found - expected).abs() < COST, "{found} for {expected}, {index} of {cell}");
        }
    }
}

/// Two means along an axis each are one over the square, also at the border.
#[test]
fn windows_agree_with_their_reference() {
    let packed = Field::new(packed_size(), |at| [0, 1, 2, 3].map(|i| 0.12 * noise(at, 30 + i)));
    let inference = uniform(&inference(CELLS, BETWEEN, BACKDROP));
    let mut means = Channels::holding(&packed);
    for along_x in [1.0, 0.0] {
        let next = Channels::<4>::new(packed_size());
        let along = pass::<4>("window", &[("ALONG_X", along_x)]);
        let costs = means.view();
        let bindings = vec![inference.as_entire_binding(), Texture(&costs)];
        draw(&along, bindings, &next.view());
        means = next;
    }
    let means = means.read();
    for index in 0..HYPOTHESES {
        let (costs, found) = (unpacked(&packed, index), unpacked(&means, index));
        for cell in cells(CELLS) {
            let (found, expected) = (found.at(cell), window(&costs, cell));
            assert!((found - expected).abs() < COST, "{found} for {expected}, {index} of {cell}");
        }
    }
}

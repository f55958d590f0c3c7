//! What the passes over the grid are run with.

use glam::UVec2;

use crate::infer::{gpu_data, sources};
use crate::kernel_tests::channels;
use crate::screen::ScreenPass;

/// The pass of that name, with values for its override constants, into `N` channels of f32.
pub(super) fn pass<const N: usize>(name: &str, constants: &[(&str, f64)]) -> ScreenPass {
    channels::pass::<N>(sources(), name, constants)
}

/// A grid whose cells are 4 pixels wide, with hypotheses between the backdrop and the diffused
/// depth, and one nearer.
pub(super) fn inference(cells: UVec2, between: u32, backdrop: f32) -> gpu_data::Inference {
    gpu_data::Inference {
        size: (4 * cells).to_array(),
        cells: cells.to_array(),
        step: 4,
        hypotheses: between + 3,
        diffused_index: between + 1,
        rigs: 0,
        backdrop,
        has_before: 0,
        padding: [0; 2],
    }
}

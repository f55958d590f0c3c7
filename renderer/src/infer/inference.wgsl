// The grid on which depths are inferred, and its hypotheses.

// Mirrors `gpu_data::Inference` in infer/mod.rs.
struct Inference {
    // Of the picture, pixels.
    size: vec2<u32>,
    // Of the grid.
    cells: vec2<u32>,
    // Pixels a side of a cell.
    step: u32,
    // How many hypotheses a cell has: the backdrop, those between, the diffused one, and one
    // nearer than that.
    hypotheses: u32,
    // Which of them is the diffused one.
    diffused_index: u32,
    // How many rigs are asked.
    rigs: u32,
    // Inverse range of the backdrop, 1/m.
    backdrop: f32,
    // 1 where the depths of a picture before this one are known.
    has_before: u32,
    padding: vec2<u32>,
}

// Inverse range, 1/m, of a hypothesis, which need not be whole; diffused: what the neighbours say.
fn hypothesis(inference: Inference, index: f32, diffused: f32) -> f32 {
    return mix(inference.backdrop, diffused, index / f32(inference.diffused_index));
}

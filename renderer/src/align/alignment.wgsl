// One level of the grid on which two photographs are aligned. Equations in align/reference.rs.

// Mirrors `gpu_data::Alignment` in align/mod.rs.
struct Alignment {
    // Of this level.
    cells: vec2<u32>,
    // Pixels a side of a cell, of this level and of the coarser one before it.
    step: f32,
    coarser_step: f32,
    // Share of the displacement that the first photograph takes; the second takes the rest.
    share: f32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

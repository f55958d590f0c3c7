// One level of the grid on which two photographs are aligned. Equations in align/reference.rs.

// Mirrors `gpu_data::Alignment` in align/mod.rs.
struct Alignment {
    // Of this level, and where they begin in a sheet of all levels.
    cells: vec2<u32>,
    origin: vec2<u32>,
    // Pixels a side of a cell, of this level and of the coarser one before it.
    step: f32,
    coarser_step: f32,
    // Share of the displacement that the first photograph takes; the second takes the rest.
    share: f32,
    // How far to the right of the first the second photograph is in a sheet of both.
    across: u32,
}

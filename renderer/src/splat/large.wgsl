// Discs that are left to quads. Needs disc.wgsl.

// Mirrors `gpu_data::Large` in splat/quads.rs.
struct Large {
    middle_slope: vec4<f32>,
    // Then what it is put behind, as its block, see drawn.wgsl.
    lift_depth_behind: vec4<f32>,
    low_high: vec4<f32>,
    // Bits of the conic, and the index.
    conic_index: vec4<u32>,
}

// Discs that are left to quads. Needs disc.wgsl.

// Mirrors `gpu_data::Large` in splat/quads.rs.
struct Large {
    middle: vec2<f32>,
    slope: vec2<f32>,
    lift: vec2<f32>,
    low: vec2<f32>,
    high: vec2<f32>,
    depth: f32,
    index: u32,
    conic: vec3<f32>,
    // As of its block, see drawn.wgsl.
    behind_m: f32,
}

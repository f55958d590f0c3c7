// What a map of points holds: see points/remote.rs.

// Metres between its ranks.
const RANK_M: f32 = 16384.0;

// Depths of points, no number where there is none.
fn point_depths(held: vec4<f32>) -> vec4<f32> {
    return held - RANK_M * floor(held / RANK_M);
}

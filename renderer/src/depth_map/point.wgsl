// What a map of points holds: see points/remote.rs.

// Metres between its ranks.
const RANK_M: f32 = 16384.0;

// Depth of the point, no number where there is none.
fn point_depth(held: f32) -> f32 {
    return held - RANK_M * floor(held / RANK_M);
}

// Whether a place and a texel of a depth map are of the same surface. Equations and reasons in
// gains/reference.rs.

// How far a place may lie off the surface that a depth map knows there: metres, and a share of
// its depth.
const AGREES_M: f32 = 0.15;
const AGREES_SHARE: f32 = 0.02;
// Share of its depth by which a surface may recede within what is averaged around a place.
const SAME_SURFACE_SHARE: f32 = 0.2;

// Depth and uncertainty, metres; beyond everything where nothing is known. mesh: depth and
// uncertainty; point: depth, no number where there is none.
fn known_surface(mesh: vec2<f32>, point: f32) -> vec2<f32> {
    return select(mesh, vec2(point, 0.0), point <= mesh.x + mesh.y);
}

fn agrees(z: f32, known: vec2<f32>) -> bool {
    return abs(z - known.x) <= AGREES_M + AGREES_SHARE * z + known.y;
}

fn is_same_surface(z: f32, beside: vec2<f32>) -> bool {
    return abs(z - beside.x) <= SAME_SURFACE_SHARE * z;
}

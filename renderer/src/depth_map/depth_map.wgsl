// Whether a photograph sees a place, by its depth map. Equations and reasons in
// depth_map/reference.rs.

// Lidar ranges are good to centimetres.
const POINT_NOISE_M: f32 = 0.03;
// Sine of the angle between ray and plane below which relief grows no further.
const LEAST_SLOPE: f32 = 0.1;
// Metres by which points may stand before a place and yet be its surface, measured on another
// drive; what is left of visibility where they do.
const UNDECIDED_M: f32 = 0.4;
const UNDECIDED: f32 = 1e-4;

// What one texel knows: nearest mesh (depth, uncertainty) and nearest point, metres; a point that
// is no number where there is none.
struct Occluders {
    mesh: vec2<f32>,
    point: f32,
}

// Depth, on the ray of a texel's centre, of the plane through c with normal n (camera frame),
// at most that of c itself.
fn depth_on_texel_ray(c: vec3<f32>, n: vec3<f32>, ray: vec3<f32>) -> f32 {
    let z = dot(n, c) / dot(n, ray);
    return select(c.z, clamp(z, 0.5 * c.z, c.z), z > 0.0);
}

// How far before a place, in depth, points on a texel's ray still belong to its surface: those
// that stand out of the plane with normal n (camera frame) by relief_m.
fn relief_depth(relief_m: f32, n: vec3<f32>, ray: vec3<f32>) -> f32 {
    return relief_m / max(abs(dot(n, ray)), LEAST_SLOPE);
}

// By how much, in depth, a map may be wrong about the surface with normal n (camera frame) on a
// ray: the width of a texel there, and what the camera's place, uncertain by pose_m, makes of the
// surface's slope.
fn depth_bias(texel_m: f32, pose_m: f32, n: vec3<f32>, ray: vec3<f32>) -> f32 {
    return texel_m + pose_m * (1.0 + length(n.xy) / max(abs(dot(n, ray)), LEAST_SLOPE));
}

// 1 where the texel sees the place, 0 where it does not. z: depth of the place on its ray; bias: see depth_bias; is_point: what the place is;
// relief: see relief_depth.
fn visibility(z: f32, bias: f32, is_point: bool, relief: f32, occluders: Occluders) -> f32 {
    let behind_mesh = occluders.mesh.x + bias + select(0.0, occluders.mesh.y, is_point);
    let hidden_by_m = z - relief - (occluders.point + bias + POINT_NOISE_M);
    // Written so that a texel without point, which is no number, hides nothing.
    let undecided = UNDECIDED * max(1.0 - hidden_by_m / UNDECIDED_M, 0.0);
    let share = select(1.0, undecided, hidden_by_m > 0.0);
    return select(0.0, share, z <= behind_mesh);
}

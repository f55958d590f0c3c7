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

// What four texels know: the nearest mesh, for a place that is a point as far behind it as it is
// uncertain; and the nearest point, no number where there is none; metres.
struct Occluders {
    mesh: vec4<f32>,
    point: vec4<f32>,
}

// Depths, on the rays of four texels' centres, of the plane through c with normal n (camera frame), at
// most that of c itself. across: one over n . ray of each.
fn depths_on_texel_rays(c: vec3<f32>, n: vec3<f32>, across: vec4<f32>) -> vec4<f32> {
    let z = dot(n, c) * across;
    // Software devices take three steps for a minimum, lest it be no number, and two for this.
    let near = select(z, vec4(0.5 * c.z), z < vec4(0.5 * c.z));
    return select(vec4(c.z), near, (z > vec4(0.0)) & (z < vec4(c.z)));
}

// How far before a place, in depth, points on the texels' rays still belong to its surface: those
// that stand out of the plane with normal n (camera frame) by relief_m. across: one over n . ray.
fn relief_depths(relief_m: f32, across: vec4<f32>) -> vec4<f32> {
    return relief_m * min(abs(across), vec4(1.0 / LEAST_SLOPE));
}

// By how much, in depth, a map may be wrong about the surface with normal n (camera frame) on a
// ray: the width of a texel there, and what the camera's place, uncertain by pose_m, makes of the
// surface's slope.
fn depth_bias(texel_m: f32, pose_m: f32, n: vec3<f32>, ray: vec3<f32>) -> f32 {
    return texel_m + pose_m * (1.0 + length(n.xy) / max(abs(dot(n, ray)), LEAST_SLOPE));
}

// For each texel 1 where it sees the place, 0 where it does not. z: depths of the place on their rays;
// bias: see depth_bias; relief: see relief_depths.
fn visibilities(
    z: vec4<f32>,
    bias: f32,
    relief: vec4<f32>,
    occluders: Occluders,
) -> vec4<f32> {
    let least_z = z - bias;
    let hidden_by_m = least_z - relief - (occluders.point + POINT_NOISE_M);
    // Written so that a texel without point, which is no number, hides nothing.
    let undecided = UNDECIDED - (UNDECIDED / UNDECIDED_M) * hidden_by_m;
    let hidden = select(vec4(0.0), undecided, undecided > vec4(0.0));
    let share = select(vec4(1.0), hidden, hidden_by_m > vec4(0.0));
    return select(vec4(0.0), share, least_z <= occluders.mesh);
}

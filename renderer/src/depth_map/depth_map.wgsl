// Whether a photograph sees a place, by its depth map. Equations and reasons in
// depth_map/reference.rs.

// Lidar ranges are good to centimetres.
const POINT_NOISE_M: f32 = 0.03;
// Depth where there is nothing.
const NOTHING_M: f32 = 1e30;

// What one texel knows: nearest mesh (depth, uncertainty) and nearest point, metres.
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

// z: depth of the place on this texel's ray; texel_m: width of the texel there;
// delta: uncertainty of the place if it is mesh, negative if it is a point.
fn is_visible(z: f32, texel_m: f32, delta: f32, occluders: Occluders) -> bool {
    let behind_point = occluders.point + texel_m + POINT_NOISE_M;
    if delta < 0.0 {
        return z <= occluders.mesh.x + occluders.mesh.y + texel_m && z <= behind_point;
    }
    return z <= occluders.mesh.x + texel_m && z - delta <= behind_point;
}

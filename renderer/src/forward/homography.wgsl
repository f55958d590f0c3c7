// The homography that a plane induces between the view and a photograph. Derivation in
// forward/reference.rs. Needs camera.wgsl.

// Sine of the angle between ray and plane below which a plane has no homography.
const EDGE_ON: f32 = 1e-6;

// The plane through p with normal n, as N with N · (P - C) = 1, of which p is relative to C; 0
// where it is seen edge-on.
fn plane_through(p: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let off = dot(n, p);
    return select(vec3(0.0), n / off, abs(off) > EDGE_ON * length(p));
}

// What a photograph knows of the place that the plane shows at a pixel q, counted from `pixel`:
// H (q, 1) is (p', 1) / z, p' the place in the photograph's frame, metres, and z its depth in
// the view.
//
// plane: of plane_through. turn: rows are the photograph's axes. e: the view's centre in the
// photograph's frame, metres.
fn homography(
    camera: Camera,
    pixel: vec2<f32>,
    plane: vec3<f32>,
    turn: mat3x3<f32>,
    e: vec3<f32>,
) -> mat3x4<f32> {
    let ray = ray_through(camera, normalised(camera, pixel));
    let across = camera.right / camera.focal.x;
    let down = camera.down / camera.focal.y;
    return mat3x4(
        column(plane, turn, e, across),
        column(plane, turn, e, down),
        column(plane, turn, e, ray.direction),
    );
}

// (M' + E' N^T) v, and N · v.
fn column(plane: vec3<f32>, turn: mat3x3<f32>, e: vec3<f32>, v: vec3<f32>) -> vec4<f32> {
    let inverse_depth = dot(plane, v);
    return vec4(turn * v + e * inverse_depth, inverse_depth);
}

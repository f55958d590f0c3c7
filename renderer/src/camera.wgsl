// A posed camera without distortion. Mirrors `gpu_data::Camera` in camera.rs. Positions are
// world-aligned and relative to the camera's centre; the axes are the rows of cam_from_world.

struct Camera {
    right: vec3<f32>,
    near: f32,
    down: vec3<f32>,
    // 1: rays are parallel to the axis, and `focal` is in pixels a metre. 0: a pinhole.
    orthographic: u32,
    forward: vec3<f32>,
    padding_1: u32,
    focal: vec2<f32>,
    centre: vec2<f32>,
    size: vec2<u32>,
    padding_2: vec2<u32>,
}

// World-aligned: origin + depth * direction is the place at a depth along the axis.
struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

fn cam_from_world(camera: Camera, p: vec3<f32>) -> vec3<f32> {
    return vec3(dot(camera.right, p), dot(camera.down, p), dot(camera.forward, p));
}

fn world_from_cam(camera: Camera, p: vec3<f32>) -> vec3<f32> {
    return camera.right * p.x + camera.down * p.y + camera.forward * p.z;
}

// Position of a pixel on the plane at depth 1.
fn normalised(camera: Camera, pixel: vec2<f32>) -> vec2<f32> {
    return (pixel - camera.centre) / camera.focal;
}

// Direction, depth 1, of a pixel position of a pinhole.
fn ray_from_pixel(camera: Camera, pixel: vec2<f32>) -> vec3<f32> {
    return vec3(normalised(camera, pixel), 1.0);
}

fn ray_through(camera: Camera, m: vec2<f32>) -> Ray {
    let aside = camera.right * m.x + camera.down * m.y;
    let parallel = camera.orthographic == 1u;
    return Ray(
        select(vec3(0.0), aside, parallel),
        camera.forward + select(aside, vec3(0.0), parallel),
    );
}

fn on_ray(ray: Ray, depth: f32) -> vec3<f32> {
    return ray.origin + depth * ray.direction;
}

// Depth at which the ray meets the plane n . p = d, given as (n, d).
fn plane_depth(plane: vec4<f32>, ray: Ray) -> f32 {
    return (plane.w - dot(plane.xyz, ray.origin)) / dot(plane.xyz, ray.direction);
}

// Unit, from p to the eye.
fn facing(camera: Camera, p: vec3<f32>) -> vec3<f32> {
    return select(-normalize(p), -camera.forward, camera.orthographic == 1u);
}

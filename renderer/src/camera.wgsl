// A posed pinhole. Mirrors `gpu_data::Camera` in camera.rs. Positions are world-aligned and
// relative to the camera's centre; the axes are the rows of cam_from_world.

struct Camera {
    right: vec3<f32>,
    near: f32,
    down: vec3<f32>,
    padding_0: u32,
    forward: vec3<f32>,
    padding_1: u32,
    focal: vec2<f32>,
    centre: vec2<f32>,
    size: vec2<u32>,
    padding_2: vec2<u32>,
}

fn cam_from_world(camera: Camera, p: vec3<f32>) -> vec3<f32> {
    return vec3(dot(camera.right, p), dot(camera.down, p), dot(camera.forward, p));
}

fn world_from_cam(camera: Camera, p: vec3<f32>) -> vec3<f32> {
    return camera.right * p.x + camera.down * p.y + camera.forward * p.z;
}

// Direction, depth 1, of a pixel position.
fn ray_from_pixel(camera: Camera, pixel: vec2<f32>) -> vec3<f32> {
    return vec3((pixel - camera.centre) / camera.focal, 1.0);
}

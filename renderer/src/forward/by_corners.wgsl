// Sprites with the photograph's homogeneous coordinates at their corners, which the device
// interpolates: they are linear in the picture, and corners of sprites are corners of pixels,
// which no device moves. Needs sprites.wgsl.

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) place: vec4<f32>,
    @location(1) @interpolate(flat) key: vec3<u32>,
}

@vertex
fn sprite_vs(
    @builtin(vertex_index) corner: u32,
    @builtin(instance_index) instance: u32,
) -> Varyings {
    photograph = given;
    eye = eye_of_frame();
    let sprite = sprite_of(instance);
    let place = sprite.homography * vec3(box_corner(sprite, corner), 1.0);
    return Varyings(clip_position(sprite, corner), place, sprite.key);
}

@fragment
fn sprite_fs(in: Varyings) -> @location(0) vec4<f32> {
    photograph = given;
    eye = eye_of_frame();
    let cell = vec2<u32>(in.position.xy);
    if !is_own_pixel(cell, in.key) {
        discard;
    }
    return colour_at(in.place, in.key, cell);
}

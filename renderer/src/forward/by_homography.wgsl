// Sprites with their homography: the same for all of a sprite, evaluated at every pixel. Needs
// sprites.wgsl.

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) across: vec4<f32>,
    @location(1) @interpolate(flat) down: vec4<f32>,
    @location(2) @interpolate(flat) home: vec4<f32>,
    // The key, and the home's column in the low half and row in the high.
    @location(3) @interpolate(flat) key: vec4<u32>,
}

@vertex
fn sprite_vs(
    @builtin(vertex_index) corner: u32,
    @builtin(instance_index) instance: u32,
) -> Varyings {
    photograph = given;
    eye = eye_of_frame();
    let sprite = sprite_of(instance);
    let h = sprite.homography;
    let home = sprite.home.x | (sprite.home.y << 16u);
    return Varyings(clip_position(sprite, corner), h[0], h[1], h[2], vec4(sprite.key, home));
}

@fragment
fn sprite_fs(in: Varyings) -> @location(0) vec4<f32> {
    photograph = given;
    eye = eye_of_frame();
    let cell = vec2<u32>(in.position.xy);
    if !is_own_pixel(cell, in.key.xyz) {
        discard;
    }
    let home = vec2(in.key.w & 0xffffu, in.key.w >> 16u);
    let q = vec2<f32>(vec2<i32>(cell) - vec2<i32>(home));
    return colour_at(in.across * q.x + in.down * q.y + in.home, in.key.xyz, cell);
}

// What a photograph's depth map knows. Needs photograph.wgsl, agree.wgsl and
// point.wgsl.

@group(0) @binding(3) var map_mesh: texture_2d_array<f32>;
@group(0) @binding(4) var map_points: texture_2d_array<f32>;

// What the depth map of the photograph knows at a texel, or at the nearest one inside.
fn known_at(texel: vec2<i32>) -> vec2<f32> {
    let cell = clamp(texel, vec2(0), vec2<i32>(photograph.map_size) - 1);
    let layer = photograph.map_layer;
    let mesh = textureLoad(map_mesh, cell, layer, 0).xy;
    return known_surface(mesh, point_depth(textureLoad(map_points, cell, layer, 0).x));
}

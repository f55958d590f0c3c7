// What a photograph's depth map knows. Needs photograph.wgsl, agree.wgsl and
// point.wgsl.

// Two layers a map: depth, and that by its uncertainty behind it.
@group(0) @binding(3) var map_mesh: texture_2d_array<f32>;
@group(0) @binding(4) var map_points: texture_2d_array<f32>;

// What the depth map of the photograph knows at a texel, or at the nearest one inside.
fn known_at(texel: vec2<i32>) -> vec2<f32> {
    let cell = clamp(texel, vec2(0), vec2<i32>(photograph.map_size) - 1);
    let layer = photograph.map_layer;
    let depth = textureLoad(map_mesh, cell, 2u * layer, 0).x;
    let delta = textureLoad(map_mesh, cell, 2u * layer + 1u, 0).x - depth;
    let point = point_depths(textureLoad(map_points, cell, layer, 0)).x;
    return known_surface(vec2(depth, delta), point);
}

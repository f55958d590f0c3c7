// Looking a photograph up. Needs photograph.wgsl.

@group(0) @binding(5) var filtering: sampler;
@group(2) @binding(0) var atlas: texture_2d_array<f32>;

// Filtered linear colour and mask at a raw pixel position.
fn look_up(pixel: vec2<f32>, lod: f32) -> vec4<f32> {
    // Half a texel inside, at the coarser of the levels that are filtered.
    let inset = vec2(0.5 * exp2(ceil(lod)));
    let size = photograph.lens.size;
    let inside = clamp(pixel, inset, max(size - inset, inset));
    let uv = (photograph.corner + inside) * photograph.texel;
    return textureSampleLevel(atlas, filtering, uv, photograph.layer, lod);
}

// Looking a photograph up. Needs photograph.wgsl.

@group(0) @binding(5) var filtering: sampler;
@group(2) @binding(0) var atlas: texture_2d_array<f32>;

// Filtered masks this close to one have no masked texel in them.
const OPAQUE: f32 = 0.999;

// Whether a mask hides some of the photograph.
override MASKED: bool = true;

// Filtered linear colour at a raw pixel position, and how far inside the mask it lies, 0 to 1: 0
// where a texel that the mask hides has any part in it.
fn look_up(pixel: vec2<f32>, lod: f32) -> vec4<f32> {
    // Half a texel inside, at the coarser of the levels that are filtered.
    let inset = vec2(0.5 * exp2(ceil(lod)));
    let size = photograph.lens.size;
    let inside = clamp(pixel, inset, max(size - inset, inset));
    let at = photograph.corner + inside;
    let texel = textureSampleLevel(atlas, filtering, at * photograph.texel, photograph.layer, lod);
    if !MASKED {
        return texel;
    }
    // Software devices run every branch, but no further turn of a loop that no pixel takes.
    let levels = select(i32(ceil(lod)) + 1, 0, texel.a >= OPAQUE || texel.a == 0.0);
    var shown = true;
    for (var level = i32(floor(lod)); level < levels; level++) {
        shown = shown && is_shown(at, level);
    }
    return vec4(texel.rgb, select(0.0, texel.a, shown));
}

// Whether none of the four texels of a level around a position in the atlas is hidden.
fn is_shown(at: vec2<f32>, level: i32) -> bool {
    let scale = exp2(f32(level));
    let low = vec2<i32>(photograph.corner / scale);
    let high = vec2<i32>(ceil((photograph.corner + photograph.lens.size) / scale)) - 1;
    let first = vec2<i32>(floor(at / scale - 0.5));
    var least = 1.0;
    for (var i = 0; i < 4; i++) {
        let cell = clamp(first + vec2(i & 1, i >> 1u), low, high);
        least = min(least, textureLoad(atlas, cell, photograph.layer, level).a);
    }
    return least > 0.0;
}

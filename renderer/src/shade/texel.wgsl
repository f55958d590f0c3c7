// Looking a photograph up. Needs photograph.wgsl and srgb.wgsl.

@group(0) @binding(8) var unfiltered: sampler;
// Four bytes a texel, red in the lowest; a photograph's levels as `Place::level_corner` has them.
@group(2) @binding(0) var atlas: texture_2d_array<u32>;

// Filtered masks this close to one have no masked texel in them.
const OPAQUE: f32 = 0.999;
// To so many texels the levels of a photograph are rounded up.
const WHOLE: f32 = 16.0;

// Whether a mask hides some of the photograph.
override MASKED: bool = true;

// Linear colour at a raw pixel position, filtered as it is encoded, and how far inside the mask it
// lies, 0 to 1: 0 where a texel that the mask hides has any part in it.
//
// texels: of the full level, that are a pixel of the picture; from 1 to that of the coarsest level. The
// level of as many texels or the next fewer, a power of two, has the less part the more are over.
fn look_up(pixel: vec2<f32>, texels: f32) -> vec4<f32> {
    // Powers of two by their bits: software devices have no quick logarithm.
    let bits = bitcast<u32>(min(max(texels, 1.0), photograph.max_texels));
    let width = bitcast<f32>(bits & 0x7f800000u);
    let scale = bitcast<f32>(0x7f000000u - (bits & 0x7f800000u));
    let share = bitcast<f32>((bits & 0x7fffffu) | 0x3f800000u) - 1.0;
    // Half a texel inside, at the coarser of the levels that are filtered.
    let inset = vec2(select(width, 0.5 * width, share == 0.0));
    let size = photograph.lens.size;
    let inside = min(max(pixel, inset), max(size - inset, inset));
    let whole = ceil(size / WHOLE) * WHOLE;
    // The full level is above all others, and those side by side.
    var texel = vec4(0.0);
    var hidden = false;
    var corner = vec2(whole.x * max(1.0 - 2.0 * scale, 0.0), select(whole.y, 0.0, scale == 1.0));
    var position = inside * scale;
    var part = 1.0 - share;
    var left = share;
    // A loop, because software devices run both sides of a branch, but no turn that no pixel takes.
    loop {
        let found = of_level(corner, position, part);
        texel += found;
        hidden = hidden | (found.a < 0.0);
        if left == 0.0 {
            break;
        }
        corner = vec2(whole.x * (1.0 - scale), whole.y);
        position *= 0.5;
        part = left;
        left = 0.0;
    }
    let inside_mask = select(texel.a, 0.0, hidden);
    return vec4(linear_from_srgb(texel.rgb), select(1.0, inside_mask, MASKED));
}

// Share of what lies at a position in the level with that corner; mask -1 where some of it is hidden.
fn of_level(corner: vec2<f32>, position: vec2<f32>, share: f32) -> vec4<f32> {
    let first = floor(position - 0.5);
    let t = position - 0.5 - first;
    let between = (photograph.corner + corner + first + 1.0) * photograph.texel;
    let texels = textureGather(0, atlas, unfiltered, between, photograph.layer);
    // Counterclockwise from the lower left, as they are gathered.
    let across = vec2(1.0 - t.x, t.x);
    let down = vec2(1.0 - t.y, t.y) * (share / 255.0);
    let weight = across.xyyx * down.yyxx;
    let r = dot(weight, vec4<f32>(texels & vec4(255u)));
    let g = dot(weight, vec4<f32>((texels >> vec4(8u)) & vec4(255u)));
    let b = dot(weight, vec4<f32>((texels >> vec4(16u)) & vec4(255u)));
    let masks = texels >> vec4(24u);
    let hidden = any((masks == vec4(0u)) & (weight > vec4(0.0)));
    return vec4(r, g, b, select(dot(weight, vec4<f32>(masks)), -1.0, hidden));
}

// Both photographs, each displaced by its share of what is known from the coarser level. Needs
// alignment.wgsl and screen.wgsl.

struct Warped {
    // Of the first, of the second, and 1 where both see the cell.
    @location(0) seen: vec4<f32>,
    // In pixels.
    @location(1) displacement: vec2<f32>,
}

@group(0) @binding(0) var<uniform> alignment: Alignment;
@group(0) @binding(1) var patterns: texture_2d<f32>;
@group(0) @binding(2) var coarser: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Warped {
    var warped: Warped;
    let between = at.xy * alignment.step / alignment.coarser_step;
    let whole = vec2<i32>(textureDimensions(coarser));
    warped.displacement = bilinear(coarser, vec2(0), whole, between).xy;
    let moved = warped.displacement / alignment.step;
    let origin = vec2<i32>(alignment.origin);
    let cells = vec2<i32>(alignment.cells);
    let a = bilinear(patterns, origin, cells, at.xy - alignment.share * moved).xz;
    let b = bilinear(patterns, origin, cells, at.xy + (1.0 - alignment.share) * moved).yz;
    // Beside what one does not see, its values are those of no place.
    warped.seen = vec4(a.x, b.x, select(0.0, 1.0, min(a.y, b.y) > 0.99), 0.0);
    return warped;
}

// Of the texels from `origin` on, `size` of them: at a position among those.
fn bilinear(
    image: texture_2d<f32>,
    origin: vec2<i32>,
    size: vec2<i32>,
    position: vec2<f32>,
) -> vec4<f32> {
    let limit = size - 1;
    let between = clamp(position - 0.5, vec2(0.0), vec2<f32>(limit));
    let low = floor(between);
    let t = between - low;
    var sum = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(vec2(i & 1u, i >> 1u));
        let weight = mix(1.0 - t, t, step);
        let texel = origin + min(vec2<i32>(low + step), limit);
        sum += weight.x * weight.y * textureLoad(image, texel, 0);
    }
    return sum;
}

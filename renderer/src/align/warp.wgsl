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
    warped.displacement = bilinear(coarser, between).xy;
    let moved = warped.displacement / alignment.step;
    let a = bilinear(patterns, at.xy - alignment.share * moved).xz;
    let b = bilinear(patterns, at.xy + (1.0 - alignment.share) * moved).yz;
    // Beside what one does not see, its values are those of no place.
    warped.seen = vec4(a.x, b.x, select(0.0, 1.0, min(a.y, b.y) > 0.99), 0.0);
    return warped;
}

fn bilinear(image: texture_2d<f32>, position: vec2<f32>) -> vec4<f32> {
    let limit = vec2<i32>(textureDimensions(image)) - 1;
    let between = clamp(position - 0.5, vec2(0.0), vec2<f32>(limit));
    let low = floor(between);
    let t = between - low;
    var sum = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(vec2(i & 1u, i >> 1u));
        let weight = mix(1.0 - t, t, step);
        sum += weight.x * weight.y * textureLoad(image, min(vec2<i32>(low + step), limit), 0);
    }
    return sum;
}

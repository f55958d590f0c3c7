// The positions of the picture, with inferred places where there was nothing; those face the eye, as
// what was nothing does already. Needs octahedral.wgsl, place.wgsl, inference.wgsl and screen.wgsl.

@group(0) @binding(0) var<uniform> inference: Inference;
@group(0) @binding(1) var positions: texture_2d<u32>;
@group(0) @binding(2) var settled: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<u32> {
    let position = textureLoad(positions, vec2<i32>(at.xy), 0);
    let ray = bitcast<vec3<f32>>(position.xyz);
    if (position.w & KIND_BITS) == SHOWS_NOTHING && dot(ray, ray) > 0.0 {
        var place: Place;
        place.kind = SHOWS_INFERRED;
        place.position = ray / max(inverse_range(at.xy), 1e-9);
        place.relief_m = RELIEF_M;
        return packed_position(place, false);
    }
    return position;
}

// Bilinear between the cells.
fn inverse_range(pixel: vec2<f32>) -> f32 {
    let limit = vec2<i32>(inference.cells) - 1;
    let between = pixel / f32(inference.step) - 0.5;
    let first = floor(between);
    let t = between - first;
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(vec2(i & 1u, i >> 1u));
        let cell = clamp(vec2<i32>(first + step), vec2(0), limit);
        let weight = mix(1.0 - t, t, step);
        sum += weight.x * weight.y * textureLoad(settled, cell, 0).x;
    }
    return sum;
}

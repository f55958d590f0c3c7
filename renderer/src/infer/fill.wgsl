// Inferred places, for pixels of the picture that nothing is known of; they face the eye, as those do
// already. Needs ray.wgsl, octahedral.wgsl, place.wgsl and inference.wgsl.

@group(0) @binding(2) var<uniform> inference: Inference;
@group(0) @binding(3) var settled: texture_2d<f32>;

@fragment
fn fs(corner: Corner) -> @location(0) vec4<u32> {
    take(corner);
    let at = corner.position.xy;
    let ray = normalize(ray_through(camera, direction(at, corner.lens).xy).direction);
    var place: Place;
    place.kind = SHOWS_INFERRED;
    place.position = ray / max(inverse_range(at), 1e-9);
    place.relief_m = RELIEF_M;
    return packed_position(place, false);
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

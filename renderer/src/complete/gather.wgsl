// The mean colour of what was inferred in each cell of the grid, as far as photographs reach it.
// Needs place.wgsl and screen.wgsl.

// Pixels a side that are looked at in each cell, whatever its size.
const SAMPLES: u32 = 4u;

// Pixels a side of a cell.
@group(0) @binding(0) var<uniform> step: u32;
@group(0) @binding(1) var positions: texture_2d<u32>;
// Linear colours times their weight, and that.
@group(0) @binding(2) var blended: texture_2d<f32>;

// Linear, and the weight, 0 or 1.
@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let size = textureDimensions(positions);
    let first = vec2<u32>(at.xy) * step;
    let stride = step / SAMPLES;
    var sum = vec4(0.0);
    for (var i = 0u; i < SAMPLES * SAMPLES; i++) {
        let pixel = first + vec2(i % SAMPLES, i / SAMPLES) * stride + stride / 2u;
        let kind = textureLoad(positions, min(pixel, size - 1u), 0).w & KIND_BITS;
        let blend = textureLoad(blended, min(pixel, size - 1u), 0);
        let counts = all(pixel < size) && kind == SHOWS_INFERRED && blend.w > 0.0;
        sum += select(vec4(0.0), vec4(blend.rgb / blend.w, 1.0), counts);
    }
    return sum / max(sum.w, 1.0);
}

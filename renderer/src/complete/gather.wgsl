// The mean colours of what was inferred, of the ground, and of all surfaces in each cell of the grid, as far as
// photographs reach them. Needs place.wgsl and screen.wgsl.

// Pixels a side that are looked at in each cell, whatever its size.
const SAMPLES: u32 = 4u;

// Pixels a side of a cell.
@group(0) @binding(0) var<uniform> step: u32;
@group(0) @binding(1) var positions: texture_2d<u32>;
@group(0) @binding(2) var orientations: texture_2d<u32>;
// Linear colours times their weight, and that.
@group(0) @binding(3) var blended: texture_2d<f32>;

// Linear, and the weight, 0 or 1.
struct Colours {
    @location(0) inferred: vec4<f32>,
    @location(1) ground: vec4<f32>,
    @location(2) surfaces: vec4<f32>,
}

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Colours {
    let size = textureDimensions(positions);
    let first = vec2<u32>(at.xy) * step;
    let stride = step / SAMPLES;
    var inferred = vec4(0.0);
    var ground = vec4(0.0);
    var surfaces = vec4(0.0);
    for (var i = 0u; i < SAMPLES * SAMPLES; i++) {
        let pixel = first + vec2(i % SAMPLES, i / SAMPLES) * stride + stride / 2u;
        let inside = min(pixel, size - 1u);
        let kind = textureLoad(positions, inside, 0).w & KIND_BITS;
        let blend = textureLoad(blended, inside, 0);
        let coloured = all(pixel < size) && blend.w > 0.0;
        let colour = vec4(blend.rgb / max(blend.w, 1e-30), 1.0);
        let code = textureLoad(orientations, inside, 0).y;
        inferred += select(vec4(0.0), colour, coloured && kind == SHOWS_INFERRED);
        ground += select(vec4(0.0), colour, coloured && is_ground(kind, code));
        let is_surface = kind == SHOWS_MESH || kind == SHOWS_POINT;
        surfaces += select(vec4(0.0), colour, coloured && is_surface);
    }
    return Colours(mean(inferred), mean(ground), mean(surfaces));
}

// Of a sum of colours, and how many they are.
fn mean(sum: vec4<f32>) -> vec4<f32> {
    return sum / max(sum.w, 1.0);
}

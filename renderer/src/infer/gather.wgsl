// What is known of each cell of the grid. Needs place.wgsl, inference.wgsl and screen.wgsl.

struct Gathered {
    // Unit direction from the eye, world axes, zero where the lens sees nothing; and the share of
    // the cell that shows geometry.
    @location(0) ray: vec4<f32>,
    // Mean inverse range of that geometry, 1/m, times its weight, 0 or 1; and the weight.
    @location(1) known: vec4<f32>,
}

// Pixels a side that are looked at in each cell, whatever its size.
const SAMPLES: u32 = 4u;

@group(0) @binding(0) var<uniform> inference: Inference;
@group(0) @binding(1) var positions: texture_2d<u32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Gathered {
    let first = vec2<u32>(at.xy) * inference.step;
    let stride = inference.step / SAMPLES;
    var rays = vec3(0.0);
    var inverse = 0.0;
    var known = 0.0;
    var looked = 0.0;
    for (var i = 0u; i < SAMPLES * SAMPLES; i++) {
        let pixel = first + vec2(i % SAMPLES, i / SAMPLES) * stride + stride / 2u;
        if any(pixel >= inference.size) {
            continue;
        }
        let shown = textureLoad(positions, vec2<i32>(pixel), 0);
        let position = bitcast<vec3<f32>>(shown.xyz);
        let range = length(position);
        if range > 0.0 {
            rays += position / range;
            looked += 1.0;
            if (shown.w & KIND_BITS) != SHOWS_NOTHING {
                inverse += 1.0 / range;
                known += 1.0;
            }
        }
    }
    var gathered: Gathered;
    if looked > 0.0 {
        gathered.ray = vec4(normalize(rays), known / looked);
    }
    if known > 0.0 {
        gathered.known = vec4(inverse / known, 0.0, 0.0, 1.0);
    }
    return gathered;
}

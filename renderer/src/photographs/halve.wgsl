// One level of a photograph from the finer one. Mirrors `gpu_data::Halve` in photographs/atlas.rs.
// Texels are words of four bytes, colours in sRGB; their means are of linear ones. Needs screen.wgsl
// and srgb.wgsl.

struct Halve {
    // Where the finer level lies, and its size there.
    source_corner: vec2<u32>,
    source_size: vec2<u32>,
}

@group(0) @binding(0) var<uniform> halve: Halve;
@group(0) @binding(1) var source: texture_2d<u32>;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) u32 {
    let first = 2u * vec2<u32>(position.xy);
    var colour = vec3(0.0);
    var alpha = 0.0;
    var least = 1.0;
    for (var i = 0u; i < 4u; i++) {
        // Odd sizes: the last texel stands for one texel twice.
        let texel = min(first + vec2(i & 1u, i >> 1u), halve.source_size - 1u);
        let value = unpack4x8unorm(textureLoad(source, halve.source_corner + texel, 0).x);
        colour += linear_from_srgb(value.rgb) * value.a;
        alpha += value.a;
        least = min(least, value.a);
    }
    // Masked texels have no say in the colour, but mask the whole texel.
    let encoded = srgb_from_linear(colour / max(alpha, 1e-6));
    return pack4x8unorm(vec4(encoded, select(0.0, 0.25 * alpha, least > 0.0)));
}

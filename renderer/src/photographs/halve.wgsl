// One level of a photograph from the finer one, inside an atlas. Mirrors `gpu_data::Halve`
// in photographs/atlas.rs. Colours are linear here: the textures are sRGB.

struct Halve {
    // Where the photograph lies in the finer level, and its size there.
    source_corner: vec2<u32>,
    source_size: vec2<u32>,
    // Where it lies in this level.
    target_corner: vec2<u32>,
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> halve: Halve;
@group(0) @binding(1) var source: texture_2d<f32>;

@vertex
fn vs(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle over the viewport.
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let first = 2u * (vec2<u32>(position.xy) - halve.target_corner);
    var colour = vec3(0.0);
    var alpha = 0.0;
    var least = 1.0;
    for (var i = 0u; i < 4u; i++) {
        // Odd sizes: the last texel stands for one texel twice.
        let texel = min(first + vec2(i & 1u, i >> 1u), halve.source_size - 1u);
        let value = textureLoad(source, halve.source_corner + texel, 0);
        colour += value.rgb * value.a;
        alpha += value.a;
        least = min(least, value.a);
    }
    // Masked texels have no say in the colour, but mask the whole texel.
    return vec4(colour / max(alpha, 1e-6), select(0.0, 0.25 * alpha, least > 0.0));
}

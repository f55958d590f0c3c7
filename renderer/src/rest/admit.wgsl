// What the nearest rigs have said as what the others are added to, and as a depth how many of those
// count. Needs screen.wgsl.

struct Carried {
    @location(0) said: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@group(0) @binding(0) var nearest: texture_2d<f32>;
@group(0) @binding(1) var<storage, read> depths: array<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Carried {
    let cell = vec2<u32>(at.xy);
    let index = cell.y * textureDimensions(nearest).x + cell.x;
    return Carried(textureLoad(nearest, cell, 0), depths[index]);
}

// As a depth, where which of the farther rigs count. Needs screen.wgsl.

// See rest.wgsl.
@group(0) @binding(0) var limits: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @builtin(frag_depth) f32 {
    return textureLoad(limits, vec2<i32>(at.xy), 0).x;
}

// The coarsest level of the pyramid, made whole. Needs screen.wgsl.

// Where nothing is known, weight 0.
@group(0) @binding(0) var<uniform> otherwise: vec4<f32>;
@group(0) @binding(1) var level: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let known = textureLoad(level, vec2<i32>(at.xy), 0);
    return select(otherwise, vec4(known.xyz / known.w, 1.0), known.w > 0.0);
}

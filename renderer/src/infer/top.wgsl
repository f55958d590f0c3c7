// The coarsest level of the pyramid, made whole: without any geometry it is the backdrop. Needs
// inference.wgsl and whole.wgsl.

@group(0) @binding(0) var<uniform> inference: Inference;
@group(0) @binding(1) var level: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    let known = textureLoad(level, vec2<i32>(at.xy), 0).xy;
    return select(inference.backdrop, known.x / known.y, known.y > 0.0);
}

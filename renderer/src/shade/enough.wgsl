@group(0) @binding(0) var blended: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4(textureLoad(blended, vec2<i32>(at.xy), 0).w * 0.001);
}

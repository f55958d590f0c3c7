// Fills what a level of the pyramid lacks from the next coarser one, which is whole. Needs
// screen.wgsl.

@group(0) @binding(0) var level: texture_2d<f32>;
@group(0) @binding(1) var coarser: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let known = textureLoad(level, vec2<i32>(at.xy), 0);
    let limit = vec2<i32>(textureDimensions(coarser)) - 1;
    let between = 0.5 * at.xy - 0.5;
    let first = floor(between);
    let t = between - first;
    var filled = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(vec2(i & 1u, i >> 1u));
        let texel = clamp(vec2<i32>(first + step), vec2(0), limit);
        let weight = mix(1.0 - t, t, step);
        filled += weight.x * weight.y * textureLoad(coarser, texel, 0);
    }
    return known + (1.0 - known.w) * filled;
}

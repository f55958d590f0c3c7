// A level of the pyramid from the next finer one: four values, summed by their weights, which
// count as one at most. Needs screen.wgsl.

@group(0) @binding(0) var finer: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let first = vec2<i32>(at.xy) * 2;
    let limit = vec2<i32>(textureDimensions(finer));
    var sum = vec4(0.0);
    for (var i = 0; i < 4; i++) {
        let texel = first + vec2(i & 1, i >> 1u);
        if all(texel < limit) {
            sum += textureLoad(finer, texel, 0);
        }
    }
    return sum / max(sum.w, 1.0);
}

// The colours of a frame beside it: what is near its border, mirrored, and too coarse to be taken for
// the street.

// How far beside it that goes on, in its sides.
const BESIDE: f32 = 0.5;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = clamp(in_frame(position.xy).xy, vec2<f32>(-BESIDE), vec2<f32>(1.0 + BESIDE));
    return vec4<f32>(textureSampleLevel(picture, linearly, at, 0.0).rgb, 1.0);
}

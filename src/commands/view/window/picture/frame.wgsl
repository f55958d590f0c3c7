// A frame as it would look from where one looks now; what it does not show is left as it is.

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = in_frame(position.xy);
    let off = at.xy - clamp(at.xy, vec2<f32>(0.0), vec2<f32>(1.0));
    if any(off != vec2<f32>(0.0)) || at.z <= 0.0 {
        discard;
    }
    return vec4<f32>(textureSampleLevel(picture, linearly, at.xy, 0.0).rgb, 1.0);
}

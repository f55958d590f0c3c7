// The colours of a frame beside it, too coarse to be taken for the street: near its border what is on the
// other side of that, mirrored; farther off, and behind the frame's camera, the frame's over the window.

// How far beside it the border counts, in its sides.
const BESIDE: f32 = 0.5;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = in_frame(position.xy);
    let off = length(at.xy - clamp(at.xy, vec2<f32>(0.0), vec2<f32>(1.0)));
    let far = select(smoothstep(0.0, BESIDE, off), 1.0, at.z <= 0.0);
    let near_at = clamp(at.xy, vec2<f32>(-BESIDE), vec2<f32>(1.0 + BESIDE));
    let near = textureSampleLevel(picture, linearly, near_at, 0.0).rgb;
    let over = textureSampleLevel(picture, linearly, position.xy / screen.window, 0.0).rgb;
    return vec4<f32>(mix(near, over, far), 1.0);
}

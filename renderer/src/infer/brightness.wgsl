// Needs photograph.wgsl.

// About as bright as it looks, of linear colour, at the exposure that all share.
fn brightness(linear: vec3<f32>) -> f32 {
    return sqrt(max(dot(photograph.gain * linear, vec3(0.2126, 0.7152, 0.0722)), 0.0));
}

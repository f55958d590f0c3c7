// Colours as they are encoded, IEC 61966-2-1, and linear.

// Exact to a fiftieth of a byte: a polynomial for the power of 2.4, of least error in encoded colour.
fn linear_from_srgb(encoded: vec3<f32>) -> vec3<f32> {
    let e = encoded;
    var power = 0.0872899368 * e - 0.3073931634;
    power = power * e + 0.6671717167;
    power = power * e + 0.5193786621;
    power = power * e + 0.0327464752;
    power = power * e + 0.0009168758;
    return select(power, e * (1.0 / 12.92), e <= vec3(0.04045));
}

fn srgb_from_linear(linear: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(max(linear, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055;
    return clamp(select(curve, 12.92 * linear, linear <= vec3(0.0031308)), vec3(0.0), vec3(1.0));
}

// Displacements as their neighbours have them, by how much each of those sees. Needs screen.wgsl.

@group(0) @binding(0) var solved: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec2<f32> {
    let cell = vec2<i32>(at.xy);
    let limit = vec2<i32>(textureDimensions(solved)) - 1;
    var sum = vec3(0.0);
    for (var i = 0; i < 9; i++) {
        let aside = vec2(i % 3, i / 3) - 1;
        let value = textureLoad(solved, clamp(cell + aside, vec2(0), limit), 0);
        // Binomial: 1 2 1 in both directions.
        let weight = value.z * exp2(-f32(abs(aside.x) + abs(aside.y)));
        sum += weight * vec3(value.xy, 1.0);
    }
    return sum.xy / sum.z;
}

// What of both photographs stands out of its surroundings: exposure, which changes between
// photographs, cancels, and patterns stay. Needs screen.wgsl.

// Cells to both sides, also in pair.wgsl.
const REACH: i32 = 4;

@group(0) @binding(0) var first: texture_2d<f32>;
@group(0) @binding(1) var second: texture_2d<f32>;
@group(0) @binding(2) var sums: texture_2d<f32>;

// Of the first, of the second, and 1 where both see the cell.
@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let cell = vec2<i32>(at.xy);
    let rows = i32(textureDimensions(sums).y);
    var sum = vec3(0.0);
    for (var y = max(cell.y - REACH, 0); y <= min(cell.y + REACH, rows - 1); y++) {
        sum += textureLoad(sums, vec2(cell.x, y), 0).xyz;
    }
    let a = textureLoad(first, cell, 0).xy;
    let b = textureLoad(second, cell, 0).xy;
    if a.y * b.y < 0.5 {
        return vec4(0.0);
    }
    return vec4(vec2(a.x, b.x) - sum.xy / sum.z, 1.0, 0.0);
}

// Both photographs where both see a cell, summed along rows over a window. Needs screen.wgsl.

// Cells to both sides, also in pattern.wgsl.
const REACH: i32 = 4;

@group(0) @binding(0) var first: texture_2d<f32>;
@group(0) @binding(1) var second: texture_2d<f32>;

// Sums of the first and of the second, and how many cells.
@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let cell = vec2<i32>(at.xy);
    let columns = i32(textureDimensions(first).x);
    var sums = vec4(0.0);
    for (var x = max(cell.x - REACH, 0); x <= min(cell.x + REACH, columns - 1); x++) {
        let a = textureLoad(first, vec2(x, cell.y), 0).xy;
        let b = textureLoad(second, vec2(x, cell.y), 0).xy;
        sums += a.y * b.y * vec4(a.x, b.x, 1.0, 0.0);
    }
    return sums;
}

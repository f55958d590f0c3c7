// What of both photographs stands out of its surroundings: exposure, which changes between
// photographs, cancels, and patterns stay. Needs alignment.wgsl and screen.wgsl.

// Cells to both sides, also in pair.wgsl.
const REACH: i32 = 4;

@group(0) @binding(0) var<uniform> alignment: Alignment;
@group(0) @binding(1) var sights: texture_2d<f32>;
@group(0) @binding(2) var sums: texture_2d<f32>;

// Of the first, of the second, and 1 where both see the cell.
@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let cell = vec2<i32>(at.xy);
    let first = i32(alignment.origin.y);
    let last = first + i32(alignment.cells.y) - 1;
    var sum = vec3(0.0);
    for (var i = -REACH; i <= REACH; i++) {
        let y = cell.y + i;
        let row = textureLoad(sums, vec2(cell.x, clamp(y, first, last)), 0).xyz;
        sum += select(vec3(0.0), row, y >= first && y <= last);
    }
    let a = textureLoad(sights, cell, 0).xy;
    let b = textureLoad(sights, cell + vec2(i32(alignment.across), 0), 0).xy;
    if a.y * b.y < 0.5 {
        return vec4(0.0);
    }
    return vec4(vec2(a.x, b.x) - sum.xy / sum.z, 1.0, 0.0);
}

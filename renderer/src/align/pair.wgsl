// Both photographs where both see a cell, summed along rows over a window. Needs alignment.wgsl and
// screen.wgsl.

// Cells to both sides, also in pattern.wgsl.
const REACH: i32 = 4;

@group(0) @binding(0) var<uniform> alignment: Alignment;
@group(0) @binding(1) var sights: texture_2d<f32>;

// Sums of the first and of the second, and how many cells.
@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let cell = vec2<i32>(at.xy);
    let first = i32(alignment.origin.x);
    let last = first + i32(alignment.cells.x) - 1;
    let across = i32(alignment.across);
    var sums = vec4(0.0);
    for (var i = -REACH; i <= REACH; i++) {
        let x = cell.x + i;
        let a = textureLoad(sights, vec2(clamp(x, first, last), cell.y), 0).xy;
        let b = textureLoad(sights, vec2(clamp(x, first, last) + across, cell.y), 0).xy;
        let both = select(0.0, a.y * b.y, x >= first && x <= last);
        sums += both * vec4(a.x, b.x, 1.0, 0.0);
    }
    return sums;
}

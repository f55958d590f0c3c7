// One step of Lucas and Kanade: the displacement that makes both alike, to first order. Needs
// lucas_kanade.wgsl, alignment.wgsl and screen.wgsl.

// Cells to both sides, also in along.wgsl.
const REACH: i32 = 3;
@group(0) @binding(0) var<uniform> alignment: Alignment;
@group(0) @binding(1) var fours: texture_2d<f32>;
@group(0) @binding(2) var twos: texture_2d<f32>;
@group(0) @binding(3) var displacements: texture_2d<f32>;

// The displacement, pixels, and how much there is to see.
@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let cell = vec2<i32>(at.xy);
    let rows = i32(textureDimensions(fours).y);
    var four = vec4(0.0);
    var two = vec2(0.0);
    for (var y = max(cell.y - REACH, 0); y <= min(cell.y + REACH, rows - 1); y++) {
        four += textureLoad(fours, vec2(cell.x, y), 0);
        two += textureLoad(twos, vec2(cell.x, y), 0).xy;
    }
    let step = lucas_kanade(four, two);
    let displacement = textureLoad(displacements, cell, 0).xy + alignment.step * step;
    return vec4(displacement, four.x + four.z + 1e-6, 0.0);
}

// One step of Lucas and Kanade: the displacement that makes both alike, to first order. Needs
// alignment.wgsl and whole.wgsl.

// Cells to both sides, also in along.wgsl.
const REACH: i32 = 3;
// Sum over a window of squared gradients, brightness a cell, that noise alone may have: where
// there is no more, nothing moves.
const NOISE: f32 = 0.015;
// Sum over a window of squared differences that resampling alone may have: what is no more alike
// needs no displacement.
const ALIKE: f32 = 0.007;
// Longest step, cells: beyond, the first order holds no more.
const LONGEST: f32 = 1.0;

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

// four: sums of gx gx, gx gy, gy gy and gx d; two: of gy d and d d.
fn lucas_kanade(four: vec4<f32>, two: vec2<f32>) -> vec2<f32> {
    let xx = four.x + NOISE;
    let yy = four.z + NOISE;
    let determinant = xx * yy - four.y * four.y;
    let step = vec2(four.y * two.x - yy * four.w, four.y * four.w - xx * two.x) / determinant;
    let differs = two.y / (two.y + ALIKE);
    return clamp(differs * step, vec2(-LONGEST), vec2(LONGEST));
}

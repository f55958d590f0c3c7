// A step towards the displacement that makes two pictures alike, to first order. Equation and
// reasons in align/reference.rs.

// Sum over a window of squared gradients, brightness a cell, that noise alone may have: where
// there is no more, nothing moves.
const NOISE: f32 = 0.015;
// Sum over a window of squared differences that photographs of one place may have: what differs no
// more needs no displacement.
const ALIKE: f32 = 0.1;
// Longest step, cells: beyond, the first order holds no more.
const LONGEST: f32 = 1.0;

// four: sums of gx gx, gx gy, gy gy and gx d; two: of gy d and d d.
fn lucas_kanade(four: vec4<f32>, two: vec2<f32>) -> vec2<f32> {
    let xx = four.x + NOISE;
    let yy = four.z + NOISE;
    let determinant = xx * yy - four.y * four.y;
    let step = vec2(four.y * two.x - yy * four.w, four.y * four.w - xx * two.x) / determinant;
    let differs = two.y * two.y / (two.y * two.y + ALIKE * ALIKE);
    return clamp(differs * step, vec2(-LONGEST), vec2(LONGEST));
}

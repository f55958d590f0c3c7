// What cells contribute to the normal equations, summed along rows over a window. Needs screen.wgsl.

struct Sums {
    // Of the gradient g and the difference d: gx gx, gx gy, gy gy, gx d.
    @location(0) four: vec4<f32>,
    // gy d, d d.
    @location(1) two: vec2<f32>,
}

// Cells to both sides, also in solve.wgsl.
const REACH: i32 = 3;
// Differences beyond this count less and less: there one photograph shows something else.
const ALIKE: f32 = 0.1;

@group(0) @binding(0) var warped: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Sums {
    let cell = vec2<i32>(at.xy);
    let columns = i32(textureDimensions(warped).x);
    var sums: Sums;
    var left = seen(cell - vec2(REACH + 1, 0));
    var here = seen(cell - vec2(REACH, 0));
    for (var i = -REACH; i <= REACH; i++) {
        let x = cell.x + i;
        let right = seen(vec2(x + 1, cell.y));
        let above = seen(vec2(x, cell.y - 1));
        let below = seen(vec2(x, cell.y + 1));
        let g = 0.25 * vec2(
            right.x + right.y - left.x - left.y,
            below.x + below.y - above.x - above.y,
        );
        let d = here.y - here.x;
        let all = here.z * left.z * right.z * above.z * below.z == 1.0;
        let counts = all && x >= 0 && x < columns;
        let weight = select(0.0, 1.0 / (1.0 + (d / ALIKE) * (d / ALIKE)), counts);
        sums.four += weight * vec4(g.x * g.x, g.x * g.y, g.y * g.y, g.x * d);
        sums.two += weight * vec2(g.y * d, d * d);
        left = here;
        here = right;
    }
    return sums;
}

fn seen(cell: vec2<i32>) -> vec4<f32> {
    let limit = vec2<i32>(textureDimensions(warped)) - 1;
    return textureLoad(warped, clamp(cell, vec2(0), limit), 0);
}

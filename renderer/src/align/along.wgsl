// Sums of the products along rows, over a window. Needs screen.wgsl.

struct Sums {
    @location(0) four: vec4<f32>,
    @location(1) two: vec2<f32>,
}

// Cells to both sides, also in solve.wgsl.
const REACH: i32 = 3;

@group(0) @binding(0) var fours: texture_2d<f32>;
@group(0) @binding(1) var twos: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Sums {
    let cell = vec2<i32>(at.xy);
    let columns = i32(textureDimensions(fours).x);
    var sums: Sums;
    for (var x = max(cell.x - REACH, 0); x <= min(cell.x + REACH, columns - 1); x++) {
        sums.four += textureLoad(fours, vec2(x, cell.y), 0);
        sums.two += textureLoad(twos, vec2(x, cell.y), 0).xy;
    }
    return sums;
}

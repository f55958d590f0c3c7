// Means over a window, along one axis, within the cells of each four hypotheses. Needs
// inference.wgsl and screen.wgsl.

override ALONG_X: bool = true;

// Cells to both sides.
const REACH: i32 = 5;

@group(0) @binding(0) var<uniform> inference: Inference;
@group(0) @binding(1) var costs: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let cells = vec2<i32>(inference.cells);
    let tall = vec2<i32>(at.xy);
    let first_row = tall.y / cells.y * cells.y;
    let cell = vec2(tall.x, tall.y - first_row);
    var sum = vec4(0.0);
    var count = 0.0;
    for (var i = -REACH; i <= REACH; i++) {
        let other = cell + select(vec2(0, i), vec2(i, 0), ALONG_X);
        if all(other >= vec2(0)) && all(other < cells) {
            sum += textureLoad(costs, vec2(other.x, first_row + other.y), 0);
            count += 1.0;
        }
    }
    return sum / count;
}

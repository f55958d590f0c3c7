// Lone choices give way to their neighbours': the median of three by three cells. Needs
// inference.wgsl and screen.wgsl.

@group(0) @binding(0) var<uniform> inference: Inference;
@group(0) @binding(1) var diffused: texture_2d<f32>;
@group(0) @binding(2) var chosen: texture_2d<f32>;

// Inverse range, 1/m.
@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    let cell = vec2<i32>(at.xy);
    let limit = vec2<i32>(inference.cells) - 1;
    var sorted: array<f32, 9>;
    for (var i = 0; i < 9; i++) {
        let value = textureLoad(chosen, clamp(cell + vec2(i % 3, i / 3) - 1, vec2(0), limit), 0).x;
        var place = i;
        while place > 0 && sorted[place - 1] > value {
            sorted[place] = sorted[place - 1];
            place--;
        }
        sorted[place] = value;
    }
    return hypothesis(inference, sorted[4], textureLoad(diffused, cell, 0).x);
}

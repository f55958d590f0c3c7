// How much the two nearest rigs that see a hypothesis disagree on it, for four hypotheses at a
// time. Needs inference.wgsl and screen.wgsl.

// More is no worse: there one of them sees something else.
const WORST: f32 = 0.12;
// Where less than two rigs see it: worse than an ordinary match, or everything would be best
// where nobody looks.
const UNSEEN: f32 = 0.08;

@group(0) @binding(0) var<uniform> inference: Inference;
@group(0) @binding(1) var sights: texture_2d_array<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let packed = vec2<u32>(at.xy);
    let row = packed.y % inference.cells.y;
    let index = packed.y / inference.cells.y * 4u;
    var costs = vec4(UNSEEN);
    for (var i = 0u; i < 4u; i++) {
        let cost = disagreement(vec2(packed.x, (index + i) * inference.cells.y + row));
        costs[i] = select(UNSEEN, cost, index + i < inference.hypotheses);
    }
    return costs;
}

fn disagreement(tall: vec2<u32>) -> f32 {
    var first = 0.0;
    var count = 0u;
    var cost = UNSEEN;
    // Of the cell, too, so that the loop does not depend on a uniform alone: see shade/colour.wgsl.
    let rigs = select(inference.rigs, 0u, tall.x == 0xffffffffu);
    for (var rig = 0u; (rig < rigs) & (count < 2u); rig++) {
        let seen = textureLoad(sights, tall, rig, 0).xy;
        if seen.y > 0.5 {
            cost = select(cost, min(abs(seen.x - first), WORST), count == 1u);
            first = seen.x;
            count++;
        }
    }
    return cost;
}

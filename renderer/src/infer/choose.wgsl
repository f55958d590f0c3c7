// Which hypothesis of each cell wins, and where between its neighbours the best one lies. Needs
// lens.wgsl, inference.wgsl and screen.wgsl.

// The picture before this one. Mirrors `gpu_data::Before` in infer/mod.rs.
struct Before {
    lens: Lens,
    // Rows of its cam_from_world.
    right: vec3<f32>,
    step: f32,
    down: vec3<f32>,
    padding_0: u32,
    forward: vec3<f32>,
    padding_1: u32,
    // Its eye relative to this one's.
    eye: vec3<f32>,
    padding_2: u32,
}

// What a hypothesis as far from the diffused one as the backdrop half way costs more: enough
// where a saturated sky agrees with everything.
const PRIOR: f32 = 0.01;
// What a hypothesis costs less that the picture before this one settled on: enough where two
// are about as good, so that pixels do not change their minds at every step.
const KEPT: f32 = 0.004;

@group(0) @binding(0) var<uniform> inference: Inference;
@group(0) @binding(1) var rays: texture_2d<f32>;
@group(0) @binding(2) var costs: texture_2d<f32>;
@group(0) @binding(3) var diffused: texture_2d<f32>;
@group(0) @binding(4) var<uniform> before: Before;
@group(0) @binding(5) var settled_before: texture_2d<f32>;

// Index of the hypothesis.
@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    let cell = vec2<i32>(at.xy);
    // What is known is not judged.
    if textureLoad(rays, cell, 0).w > 0.5 {
        return f32(inference.diffused_index);
    }
    let last = inference.hypotheses - 1u;
    var best = 0u;
    var lowest = 1e9;
    for (var i = 0u; i <= last; i++) {
        let cost = judged(cell, i);
        if cost < lowest {
            lowest = cost;
            best = i;
        }
    }
    if best == 0u || best == last {
        return f32(best);
    }
    return f32(best) + vertex(judged(cell, best - 1u), lowest, judged(cell, best + 1u));
}

fn judged(cell: vec2<i32>, index: u32) -> f32 {
    let four = textureLoad(costs, cell + vec2(0, i32(index / 4u * inference.cells.y)), 0);
    let cost = four[index % 4u];
    return cost + prior(f32(index) / f32(inference.diffused_index)) - kept(cell, index);
}

// What the picture before this one says for a hypothesis.
fn kept(cell: vec2<i32>, index: u32) -> f32 {
    // Of the cell, too, so that it is no branch on a uniform: see shade/colour.wgsl.
    if (inference.has_before == 0u) | (cell.x < 0) {
        return 0.0;
    }
    let about = textureLoad(diffused, cell, 0).x;
    let ray = textureLoad(rays, cell, 0).xyz;
    let place = ray / max(hypothesis(inference, f32(index), about), 1e-9) - before.eye;
    let turned = vec3(dot(before.right, place), dot(before.down, place), dot(before.forward, place));
    let pixel = lens_pixel(before.lens, turned.xy / turned.z);
    let cell_before = vec2<i32>(floor(pixel.xy / before.step));
    let inside = all(pixel.xy >= vec2(0.0)) && all(pixel.xy < before.lens.size);
    if !inside || pixel.z == 0.0 || !(turned.z > 0.0) {
        return 0.0;
    }
    let apart = hypothesis(inference, 1.0, about) - inference.backdrop;
    let missed = abs(textureLoad(settled_before, cell_before, 0).x - 1.0 / length(place));
    return KEPT * max(1.0 - missed / max(apart, 1e-9), 0.0);
}

// share: of the way from the backdrop to the diffused depth.
fn prior(share: f32) -> f32 {
    return PRIOR * min(2.0 * abs(share - 1.0), 1.0);
}

// Where the parabola through the values at -1, 0 and 1 is lowest, within half a step.
fn vertex(before: f32, here: f32, after: f32) -> f32 {
    let bend = before + after - 2.0 * here;
    return select(0.0, clamp(0.5 * (before - after) / max(bend, 1e-6), -0.5, 0.5), bend > 1e-6);
}

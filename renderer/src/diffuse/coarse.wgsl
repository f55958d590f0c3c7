// All of the pyramid from a level of few cells on, at once, a workgroup for each layer: the passes of
// pull.wgsl up to a single cell, and those of push.wgsl back. FORMAT stands for that of the levels.

// Most cells of that level; a row of them, and its halves, make less than twice as many.
const CELLS: u32 = 512u;
const THREADS: u32 = 64u;

struct Coarse {
    // Where nothing is known; its weight is 0.
    otherwise: vec3<f32>,
    // The layer from which on nothing is filled.
    first_left: u32,
}

@group(0) @binding(0) var level: texture_2d_array<f32>;
@group(0) @binding(1) var diffused: texture_storage_2d_array<FORMAT, write>;
@group(0) @binding(2) var<uniform> given: Coarse;

// The levels, finest first: what is known, and then the same diffused.
var<workgroup> cells: array<vec4<f32>, 2u * CELLS>;

@compute @workgroup_size(THREADS)
fn main(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let layer = group.x;
    let finest = textureDimensions(level);
    for (var i = thread; i < finest.x * finest.y; i += THREADS) {
        cells[i] = textureLoad(level, vec2(i % finest.x, i / finest.x), layer, 0);
    }
    workgroupBarrier();
    // Of the level that is made, and of the next finer one.
    var finer = finest;
    var finer_first = 0u;
    var levels = 0u;
    while finer.x * finer.y > 1u {
        let size = (finer + 1u) / 2u;
        let first = finer_first + finer.x * finer.y;
        for (var i = thread; i < size.x * size.y; i += THREADS) {
            cells[first + i] = pulled(vec2(i % size.x, i / size.x), finer, finer_first);
        }
        workgroupBarrier();
        finer = size;
        finer_first = first;
        levels++;
    }
    let fills = layer < given.first_left;
    if thread == 0u && fills {
        let known = cells[finer_first];
        let all = vec4(known.xyz / max(known.w, 1e-30), 1.0);
        cells[finer_first] = select(vec4(given.otherwise, 0.0), all, known.w > 0.0);
    }
    workgroupBarrier();
    var coarser = finer;
    var coarser_first = finer_first;
    for (var left = levels; left > 0u; left--) {
        // As often halved as there are levels above.
        let size = (finest + (1u << (left - 1u)) - 1u) >> vec2(left - 1u);
        let first = coarser_first - size.x * size.y;
        for (var i = thread; i < size.x * size.y; i += THREADS) {
            let cell = vec2(i % size.x, i / size.x);
            let known = cells[first + i];
            let lacking = select(0.0, 1.0 - known.w, fills);
            cells[first + i] = known + lacking * between(cell, coarser, coarser_first);
        }
        workgroupBarrier();
        coarser = size;
        coarser_first = first;
    }
    for (var i = thread; i < finest.x * finest.y; i += THREADS) {
        textureStore(diffused, vec2(i % finest.x, i / finest.x), layer, cells[i]);
    }
}

// As in pull.wgsl.
fn pulled(cell: vec2<u32>, size: vec2<u32>, first: u32) -> vec4<f32> {
    var sum = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let finer = 2u * cell + vec2(i & 1u, i >> 1u);
        if all(finer < size) {
            sum += cells[first + finer.y * size.x + finer.x];
        }
    }
    return sum / max(sum.w, 1.0);
}

// As in push.wgsl.
fn between(cell: vec2<u32>, size: vec2<u32>, first: u32) -> vec4<f32> {
    let at = 0.5 * (vec2<f32>(cell) + 0.5) - 0.5;
    let low = floor(at);
    let t = at - low;
    var filled = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(vec2(i & 1u, i >> 1u));
        let coarse = vec2<u32>(clamp(low + step, vec2(0.0), vec2<f32>(size) - 1.0));
        let weight = mix(1.0 - t, t, step);
        filled += weight.x * weight.y * cells[first + coarse.y * size.x + coarse.x];
    }
    return filled;
}

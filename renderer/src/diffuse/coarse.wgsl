// All of the pyramid from a level of few cells on, at once: the passes of pull.wgsl up to a single
// cell, and those of push.wgsl back. FORMAT stands for that of the levels.

// Most cells of that level; a row of them, and its halves, make less than twice as many.
const CELLS: u32 = 512u;
const THREADS: u32 = 64u;

@group(0) @binding(0) var level: texture_2d<f32>;
@group(0) @binding(1) var whole: texture_storage_2d<FORMAT, write>;
// Where nothing is known, weight 0.
@group(0) @binding(2) var<uniform> otherwise: vec4<f32>;

// The levels, finest first: what is known, and then the same made whole.
var<workgroup> cells: array<vec4<f32>, 2u * CELLS>;

@compute @workgroup_size(THREADS)
fn main(@builtin(local_invocation_index) thread: u32) {
    let finest = textureDimensions(level);
    for (var i = thread; i < finest.x * finest.y; i += THREADS) {
        cells[i] = textureLoad(level, vec2(i % finest.x, i / finest.x), 0);
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
    if thread == 0u {
        let known = cells[finer_first];
        cells[finer_first] = select(otherwise, vec4(known.xyz / known.w, 1.0), known.w > 0.0);
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
            cells[first + i] = known + (1.0 - known.w) * between(cell, coarser, coarser_first);
        }
        workgroupBarrier();
        coarser = size;
        coarser_first = first;
    }
    for (var i = thread; i < finest.x * finest.y; i += THREADS) {
        textureStore(whole, vec2(i % finest.x, i / finest.x), cells[i]);
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

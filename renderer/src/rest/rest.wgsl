// How many of the farther rigs count where the nearest have spoken, pixel by pixel and for each tile.
// Equations and reasons in rest/reference.rs. Needs octahedral.wgsl, place.wgsl, blend.wgsl and heard.wgsl.

// Mirrors `gpu_data::Rig` in rest/mod.rs.
struct Rig {
    // Between its cameras, relative to the eye.
    centre: vec3<f32>,
    // How far they are from there, metres.
    reach: f32,
    // Factor of equation 4 for an eye at the rig itself.
    weight: f32,
    // Least depth at which its cameras are compared.
    floor: f32,
    // Which it is, counted from the nearest to the eye.
    index: u32,
    padding: u32,
}

// As tiles.wgsl has it.
struct Box {
    low: vec3<f32>,
    asked: u32,
    high: vec3<f32>,
    padding: u32,
}

// Pixels a side of a tile, see tiles/mod.rs.
const TILE: u32 = 32u;
// Depth behind which nothing is compared.
const NONE: f32 = 1.0;
// Room for rigs, and how many there are: a constant, so that software devices unroll the loop and read
// uniforms once.
const MAX_RIGS: u32 = 30u;
override RIGS: u32 = MAX_RIGS;
// For rounding, here and where photographs are asked.
const MARGIN: f32 = 1.001;

@group(0) @binding(0) var positions: texture_2d<u32>;
@group(0) @binding(1) var orientations: texture_2d<u32>;
// What the nearest have said: linear colours times their weight, and that.
@group(0) @binding(2) var nearest: texture_2d<f32>;
// Storage, of which software devices read once what all threads want.
@group(0) @binding(3) var<storage, read> rigs: array<Rig, MAX_RIGS>;
// Of each pixel the depth behind which rigs do not count, and the weight of what was said.
@group(0) @binding(4) var limits: texture_storage_2d<rg32float, write>;
@group(0) @binding(5) var<storage, read_write> boxes: array<Box>;

var<workgroup> asked: array<u32, TILE>;

// One workgroup a tile, one thread a column of it.
@compute @workgroup_size(32)
fn limit(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(num_workgroups) tiles: vec3<u32>,
    @builtin(local_invocation_index) column: u32,
) {
    var known: array<Rig, MAX_RIGS>;
    for (var i = 0u; i < RIGS; i++) {
        known[i] = rigs[i];
    }
    let size = textureDimensions(positions);
    let x = tile.x * TILE + column;
    let rows = min(TILE, size.y - tile.y * TILE);
    var bits = 0u;
    for (var row = 0u; row < rows; row++) {
        let cell = vec2(x, tile.y * TILE + row);
        // Beyond the right border these read zeros: nothing.
        let record = textureLoad(positions, cell, 0);
        let normal = from_octahedral(textureLoad(orientations, cell, 0).x);
        let weight = textureLoad(nearest, cell, 0).w;
        let said = UNHEARD * weight;
        let place = bitcast<vec3<f32>>(record.xyz);
        var depth = NONE;
        for (var i = 0u; i < RIGS; i++) {
            let counts = at_most(known[i], place, normal) > said
                && (record.w & KIND_BITS) != SHOWS_NOTHING && x < size.x;
            depth = select(depth, min(depth, known[i].floor), counts);
            bits |= select(0u, 1u << known[i].index, counts);
        }
        // What lies beyond the border is not stored.
        textureStore(limits, cell, vec4(depth, weight, 0.0, 0.0));
    }
    asked[column] = bits;
    workgroupBarrier();
    if column == 0u {
        for (var other = 1u; other < TILE; other++) {
            bits |= asked[other];
        }
        boxes[tile.y * tiles.x + tile.x].asked = bits;
    }
}

// The greatest weight that any camera of a rig can have at a place.
fn at_most(rig: Rig, place: vec3<f32>, normal: vec3<f32>) -> f32 {
    let to_rig = rig.centre - place;
    let nearest = max(length(to_rig) - rig.reach, 0.0);
    let cosine = min((dot(normal, to_rig) + rig.reach) / max(nearest, 1e-6), 1.0);
    return MARGIN * rig.weight * park_weight(cosine, nearest * nearest, 0.0);
}

// Which of the farther rigs count where the nearest have spoken, pixel by pixel and for each tile. Equations
// and reasons in rest/reference.rs. Needs octahedral.wgsl, place.wgsl, screen.wgsl, blend.wgsl and heard.wgsl.

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

// Pixels a side of a tile, see tiles/mod.rs.
const TILE: u32 = 32u;
// Depth behind which nothing is compared.
const NONE: f32 = 1.0;
// Room for rigs, and how many there are: a constant, so that software devices unroll the loop.
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
// Of each tile, as tiles.wgsl has it; 0 at first.
@group(0) @binding(4) var<storage, read_write> asked: array<atomic<u32>>;

struct Limit {
    // The weight of what was said.
    @location(0) said: f32,
    // Behind which rigs do not count.
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Limit {
    let pixel = vec2<u32>(at.xy);
    let record = textureLoad(positions, pixel, 0);
    let normal = from_octahedral(textureLoad(orientations, pixel, 0).x);
    let weight = textureLoad(nearest, pixel, 0).w;
    let said = UNHEARD * weight;
    let place = bitcast<vec3<f32>>(record.xyz);
    let shows = (record.w & KIND_BITS) != SHOWS_NOTHING;
    var depth = NONE;
    var bits = 0u;
    for (var i = 0u; i < RIGS; i++) {
        let rig = rigs[i];
        let counts = shows && at_most(rig, place, normal) > said;
        depth = select(depth, min(depth, rig.floor), counts);
        bits |= select(0u, 1u << rig.index, counts);
    }
    let columns = (textureDimensions(positions).x + TILE - 1u) / TILE;
    let tile = pixel.y / TILE * columns + pixel.x / TILE;
    // Most have nothing to add.
    if (bits & ~atomicLoad(&asked[tile])) != 0u {
        atomicOr(&asked[tile], bits);
    }
    return Limit(weight, depth);
}

// The greatest weight that any camera of a rig can have at a place.
fn at_most(rig: Rig, place: vec3<f32>, normal: vec3<f32>) -> f32 {
    let to_rig = rig.centre - place;
    let nearest = max(length(to_rig) - rig.reach, 0.0);
    let cosine = min((dot(normal, to_rig) + rig.reach) / max(nearest, 1e-6), 1.0);
    return MARGIN * rig.weight * park_weight(cosine, nearest * nearest, 0.0);
}

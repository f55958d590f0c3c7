// Which of the farther rigs count where the nearest have spoken, pixel by pixel and for each tile. Equations
// and reasons in rest/reference.rs. Needs octahedral.wgsl, place.wgsl, viewport.wgsl, blend.wgsl and heard.wgsl.

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
// Room for rigs, and how many are asked at once.
const MAX_RIGS: u32 = 30u;
const AT_ONCE: u32 = 6u;
// For rounding, here and where photographs are asked.
const MARGIN: f32 = 1.001;

@group(0) @binding(0) var positions: texture_2d<u32>;
@group(0) @binding(1) var orientations: texture_2d<u32>;
// What the nearest have said: linear colours times their weight, and that.
@group(0) @binding(2) var nearest: texture_2d<f32>;
// Those that there are not have no weight.
@group(0) @binding(3) var<uniform> rigs: array<Rig, MAX_RIGS>;
// Of each tile, as tiles.wgsl has it; 0 at first.
@group(0) @binding(4) var<storage, read_write> asked: array<atomic<u32>>;

// Some of the rigs: centre and reach of each, and the bits of the rest. They come with the corners, because
// software devices read every word of a buffer once for each pixel.
struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) place_0: vec4<f32>,
    @location(1) @interpolate(flat) place_1: vec4<f32>,
    @location(2) @interpolate(flat) place_2: vec4<f32>,
    @location(3) @interpolate(flat) place_3: vec4<f32>,
    @location(4) @interpolate(flat) place_4: vec4<f32>,
    @location(5) @interpolate(flat) place_5: vec4<f32>,
    @location(6) @interpolate(flat) rest_0: vec3<u32>,
    @location(7) @interpolate(flat) rest_1: vec3<u32>,
    @location(8) @interpolate(flat) rest_2: vec3<u32>,
    @location(9) @interpolate(flat) rest_3: vec3<u32>,
    @location(10) @interpolate(flat) rest_4: vec3<u32>,
    @location(11) @interpolate(flat) rest_5: vec3<u32>,
}

// One instance a number of rigs, over the whole viewport.
@vertex
fn vs(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Corner {
    let first = instance * AT_ONCE;
    var corner: Corner;
    corner.position = corner_of_viewport(index);
    corner.place_0 = place_of(first);
    corner.place_1 = place_of(first + 1u);
    corner.place_2 = place_of(first + 2u);
    corner.place_3 = place_of(first + 3u);
    corner.place_4 = place_of(first + 4u);
    corner.place_5 = place_of(first + 5u);
    corner.rest_0 = rest_of(first);
    corner.rest_1 = rest_of(first + 1u);
    corner.rest_2 = rest_of(first + 2u);
    corner.rest_3 = rest_of(first + 3u);
    corner.rest_4 = rest_of(first + 4u);
    corner.rest_5 = rest_of(first + 5u);
    return corner;
}

fn place_of(rig: u32) -> vec4<f32> {
    return vec4(rigs[rig].centre, rigs[rig].reach);
}

fn rest_of(rig: u32) -> vec3<u32> {
    let r = rigs[rig];
    return vec3(bitcast<u32>(r.weight), bitcast<u32>(r.floor), r.index);
}

struct Limit {
    // The weight of what was said.
    @location(0) said: f32,
    // Behind which rigs do not count.
    @builtin(frag_depth) depth: f32,
}

var<private> place: vec3<f32>;
var<private> normal: vec3<f32>;
// More than what is not heard.
var<private> least: f32;
// Of the rigs that count: the least depth, and a bit each.
var<private> depth: f32;
var<private> bits: u32;

@fragment
fn fs(corner: Corner) -> Limit {
    let pixel = vec2<u32>(corner.position.xy);
    let record = textureLoad(positions, pixel, 0);
    let weight = textureLoad(nearest, pixel, 0).w;
    place = bitcast<vec3<f32>>(record.xyz);
    normal = from_octahedral(textureLoad(orientations, pixel, 0).x);
    least = UNHEARD * weight;
    depth = NONE;
    bits = 0u;
    ask(corner.place_0, corner.rest_0);
    ask(corner.place_1, corner.rest_1);
    ask(corner.place_2, corner.rest_2);
    ask(corner.place_3, corner.rest_3);
    ask(corner.place_4, corner.rest_4);
    ask(corner.place_5, corner.rest_5);
    if (record.w & KIND_BITS) == SHOWS_NOTHING {
        return Limit(weight, NONE);
    }
    let columns = (textureDimensions(positions).x + TILE - 1u) / TILE;
    let tile = pixel.y / TILE * columns + pixel.x / TILE;
    // Most have nothing to add.
    if (bits & ~atomicLoad(&asked[tile])) != 0u {
        atomicOr(&asked[tile], bits);
    }
    return Limit(weight, depth);
}

// Whether a rig counts.
fn ask(centre: vec4<f32>, rest: vec3<u32>) {
    let counts = at_most(centre.xyz, centre.w, bitcast<f32>(rest.x)) > least;
    depth = select(depth, min(depth, bitcast<f32>(rest.y)), counts);
    bits |= select(0u, 1u << rest.z, counts);
}

// The greatest weight that any camera of a rig can have at the place.
fn at_most(centre: vec3<f32>, reach: f32, weight: f32) -> f32 {
    let to_rig = centre - place;
    let distance = max(length(to_rig) - reach, 0.0);
    let cosine = min((dot(normal, to_rig) + reach) / max(distance, 1e-6), 1.0);
    return MARGIN * weight * park_weight(cosine, distance * distance, 0.0);
}

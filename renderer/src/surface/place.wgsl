// What a pixel of the picture shows, as the surface pass leaves it for the passes after it:
// in `positions`, relative to the eye in world axes, with flags; in `orientations`, the normal
// and a code. A pixel that shows nothing has the unit direction of its ray for a position, and faces
// the eye, or zero where its lens has none. Needs octahedral.wgsl.

struct Place {
    kind: u32, // of SHOWS_*
    position: vec3<f32>,
    // Unit, towards the eye.
    normal: vec3<f32>,
    // Uncertainty of mesh, metres.
    delta: f32,
    // How far points of the same surface may stand out of its plane, see depth_map.wgsl.
    relief_m: f32,
    // Class of mesh, code of a point.
    code: u32,
}

const SHOWS_NOTHING: u32 = 0u;
const SHOWS_MESH: u32 = 1u;
const SHOWS_POINT: u32 = 3u;
const SHOWS_INFERRED: u32 = 5u;
// Noise between drives, and discs that do not lie in their surface, metres.
const RELIEF_M: f32 = 0.1;

// Class of mesh that is terrain.
const GROUND: u32 = 0u;

const KIND_BITS: u32 = 7u;
const HAS_RELIEF: u32 = 8u;
const ON_EDGE: u32 = 16u;

fn packed_position(place: Place, on_edge: bool) -> vec4<u32> {
    let flags = place.kind
        | select(0u, HAS_RELIEF, place.relief_m > 0.0)
        | select(0u, ON_EDGE, on_edge)
        | (pack2x16float(vec2(0.0, place.delta)) & 0xffff0000u);
    return vec4(bitcast<vec3<u32>>(place.position), flags);
}

fn packed_orientation(place: Place) -> vec2<u32> {
    return vec2(octahedral(place.normal), place.code);
}

// code: as `Place` has it.
fn is_ground(kind: u32, code: u32) -> bool {
    return kind == SHOWS_MESH && code == GROUND;
}

fn unpacked(position: vec4<u32>, orientation: vec2<u32>) -> Place {
    var place: Place;
    place.kind = position.w & KIND_BITS;
    place.position = bitcast<vec3<f32>>(position.xyz);
    place.normal = from_octahedral(orientation.x);
    place.delta = unpack2x16float(position.w).y;
    place.relief_m = select(0.0, max(place.delta, RELIEF_M), (position.w & HAS_RELIEF) != 0u);
    place.code = orientation.y;
    return place;
}

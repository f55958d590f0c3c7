// The picture: what the photographs say together, or what is known without them. Needs
// place.wgsl, srgb.wgsl and viewport.wgsl. `Frame` as in photograph.wgsl.

struct Frame {
    forward: vec3<f32>,
    focal: f32,
    // sRGB, 0 to 1.
    background: vec3<f32>,
    orthographic: u32,
    size: vec2<f32>,
    mode: u32,
    depth_test: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var positions: texture_2d<u32>;
@group(0) @binding(2) var orientations: texture_2d<u32>;
@group(0) @binding(3) var blended: texture_2d<f32>;
// Linear, over the cells of a grid: a layer for what is inferred, and one for the ground, with a 1, or 0 where
// there is nothing to complete it by; and one for points, of the surfaces near them, times a weight of 0 to 1, and
// that.
@group(0) @binding(4) var around: texture_2d_array<f32>;
@group(0) @binding(5) var filtering: sampler;
// Pixels that those cells cover.
@group(0) @binding(6) var<uniform> spanned: vec2<f32>;

const OF_INFERRED: u32 = 0u;
const OF_GROUND: u32 = 1u;
const OF_SURFACES: u32 = 2u;

// Modes, as `Mode` in settings.rs.
const MODE_POINTS_COLOUR: u32 = 3u;
const MODE_WIREFRAME: u32 = 4u;
const MODE_DEPTH: u32 = 5u;
const MODE_NORMALS: u32 = 6u;
const MODE_UNCERTAINTY: u32 = 8u;

// The mode of the picture: software devices run every branch.
override MODE: u32 = 0u;

// What every pixel wants of the uniforms: see shade/tile.wgsl.
struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) background: vec3<f32>,
    @location(1) @interpolate(flat) per_spanned: vec2<f32>,
}

@vertex
fn vs(@builtin(vertex_index) index: u32) -> Corner {
    return Corner(corner_of_viewport(index), frame.background, 1.0 / spanned);
}

// sRGB, and in alpha the code of `Surface` in frame.rs.
@fragment
fn fs(corner: Corner) -> @location(0) vec4<f32> {
    let at = corner.position.xy;
    let cell = vec2<i32>(at);
    let position = textureLoad(positions, cell, 0);
    let place = unpacked(position, textureLoad(orientations, cell, 0).xy);
    let sum = textureLoad(blended, cell, 0);
    var colour = corner.background;
    var surface = SHOWS_NOTHING;
    let coloured = sum.w > 0.0;
    let cells = at * corner.per_spanned;
    let is_point = place.kind == SHOWS_POINT;
    let ground = is_ground(place.kind, place.code);
    let layer = select(select(OF_INFERRED, OF_GROUND, ground), OF_SURFACES, is_point);
    let given = textureSampleLevel(around, filtering, cells, layer, 0.0);
    let has_colour = coloured || (given.w > 0.5 && (ground || place.kind == SHOWS_INFERRED));
    // An inferred place without colour is none.
    if place.kind != SHOWS_NOTHING && (place.kind != SHOWS_INFERRED || has_colour) {
        surface = place.kind + select(0u, 1u, coloured);
        switch MODE {
            case MODE_POINTS_COLOUR: { colour = own_colour(place); }
            case MODE_WIREFRAME: {
                colour = select(own_colour(place), vec3(0.05), (position.w & ON_EDGE) != 0u);
            }
            case MODE_DEPTH: { colour = vec3(nearness(place)); }
            case MODE_NORMALS: { colour = 0.5 + 0.5 * place.normal; }
            case MODE_UNCERTAINTY: { colour = uncertainty_colour(place, coloured); }
            default: {
                let own = own_colour(place);
                // Encoded once, whichever it is.
                let of_point = given.rgb + (1.0 - given.w) * linear_from_srgb(own);
                let known = select(given.rgb, sum.rgb / sum.w, coloured);
                let encoded = srgb_from_linear(select(of_point, known, has_colour));
                colour = select(own, encoded, has_colour | is_point);
            }
        }
    }
    return vec4(colour, f32(surface) / 255.0);
}

// 1 at the eye, half at 10 m, 0 at infinity.
fn nearness(place: Place) -> f32 {
    return 10.0 / (10.0 + max(dot(frame.forward, place.position), 0.0));
}

// From green (a centimetre) over yellow (a decimetre) to red (a metre and more); dark where no
// photograph sees the place; magenta where it was inferred, dark as well.
fn uncertainty_colour(place: Place, coloured: bool) -> vec3<f32> {
    if place.kind == SHOWS_INFERRED {
        return vec3(0.8, 0.1, 0.8) * select(0.5, 1.0, coloured);
    }
    let metres = select(place.delta, POINT_M, place.kind == SHOWS_POINT);
    let t = clamp(0.5 + 0.5 * log2(max(metres, 0.01) / 0.1) / log2(10.0), 0.0, 1.0);
    let ramp = vec3(min(2.0 * t, 1.0), min(2.0 - 2.0 * t, 1.0), 0.1);
    return ramp * select(0.45, 0.9, coloured);
}

// Lidar is good to centimetres.
const POINT_M: f32 = 0.03;

// Where no photograph reaches: a point's own colour, else a grey lit from above.
fn own_colour(place: Place) -> vec3<f32> {
    if place.kind == SHOWS_POINT && (place.code >> 31u) == 1u {
        return unpack4x8unorm(place.code).rgb;
    }
    // Neither straight down nor along a street grid, so that faces of a block differ.
    let light = normalize(vec3(0.35, 0.2, 0.9));
    let lit = 0.65 + 0.35 * dot(place.normal, light);
    if place.kind == SHOWS_POINT {
        return vec3(0.55) * lit;
    }
    switch place.code {
        case GROUND: { return vec3(0.50, 0.50, 0.48) * lit; }
        case 1u: { return vec3(0.66, 0.65, 0.62) * lit; }
        default: { return vec3(0.60, 0.56, 0.54) * lit; }
    }
}

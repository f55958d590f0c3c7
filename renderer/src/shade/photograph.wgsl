// One photograph at a time. Needs lens.wgsl.

// Mirrors `gpu_data::Photograph` in shade/photograph.rs.
struct Photograph {
    lens: Lens,
    // Rows of cam_from_world.
    right: vec3<f32>,
    // Which texture of its atlas.
    layer: u32,
    down: vec3<f32>,
    map_layer: u32,
    forward: vec3<f32>,
    // Squared distance from the eye to the nearest camera of its rig, metres.
    eye_distance_2: f32,
    // Relative to the eye.
    centre: vec3<f32>,
    // How far its place may be off, metres.
    pose_m: f32,
    map_focal: vec2<f32>,
    map_centre: vec2<f32>,
    map_size: vec2<u32>,
    // Where it lies in its layer, texels.
    corner: vec2<f32>,
    // Factor of its linear colours.
    gain: vec3<f32>,
    // Of the full level, that are one of the coarsest.
    max_texels: f32,
    // Colour that stands for it, linear.
    mark: vec3<f32>,
    // Share of its weight that its rig's place among the nearest leaves, 0 to 1.
    rig_weight: f32,
    // How near the eye is to it, compared with the nearest of its rig, 0 to 1.
    closeness: f32,
    // How well it sees is compared as a depth from the first to the sum of both: above all that
    // rigs farther than its own have left.
    rig_floor: f32,
    rig_step: f32,
    // Share of the offsets by which it agrees with another …
    shift: f32,
    // One over the size of its layer.
    texel: vec2<f32>,
    // … and pixels between those.
    shift_step: f32,
    // One over the side of a layer of depth maps.
    map_texel: f32,
}

// Mirrors `gpu_data::Frame` in shade/mod.rs.
struct Frame {
    forward: vec3<f32>,
    // Pixels a metre at depth 1, or at any depth of an orthographic view.
    focal: f32,
    background: vec3<f32>,
    orthographic: u32,
    size: vec2<f32>,
    mode: u32,
    // 1 where a photograph colours only what it sees, 0 where it goes through everything.
    depth_test: u32,
}

struct Projected {
    // Of the camera frame, metres.
    position: vec3<f32>,
    // x/z, y/z.
    normalised: vec2<f32>,
    // Raw pixel.
    pixel: vec2<f32>,
    // Distance from the picture's border as a share of its shorter side; 0 where it sees nothing.
    border: f32,
}

// Metres. Nothing nearer to a photograph's eye plane is looked up in it.
const NEAREST_DEPTH_M: f32 = 0.05;

// Directions further than this from its axis (tangent; 80°) are not in a photograph's depth map,
// see pinhole.rs, and not looked up in it.
const MAX_TANGENT: f32 = 5.67;

// The lens model of the photographs of this pipeline: software devices run every branch.
override LENS_MODEL: u32 = 0u;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var positions: texture_2d<u32>;
@group(1) @binding(0) var<uniform> given: Photograph;

// What entry points take `given` for, each in its way: see tile.wgsl.
var<private> photograph: Photograph;

// What of the frame fragments want, taken from where that is quick as well.
struct Eye {
    // Its dot product with a place, and 1 times its last, is as deep as the place counts: see
    // `view_depth_of`.
    axis: vec4<f32>,
    // Texels of the photograph's full level that are a pixel, of a place equally far from both.
    texels_per_pixel: f32,
    tests_depth: bool,
    shows_marks: bool,
}

const MODE_SOURCES: u32 = 7u;

var<private> eye: Eye;

fn eye_of_frame() -> Eye {
    let axis = select(vec4(frame.forward, 0.0), vec4(0.0, 0.0, 0.0, 1.0), frame.orthographic == 1u);
    let texels = given.lens.focal.y / frame.focal;
    return Eye(axis, texels, frame.depth_test == 1u, frame.mode == MODE_SOURCES);
}

// place: relative to the eye, world axes.
fn projected(place: vec3<f32>) -> Projected {
    return seen_at(turned(place - photograph.centre));
}

// A direction of the world in the photograph's frame.
fn turned(direction: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(photograph.right, direction),
        dot(photograph.down, direction),
        dot(photograph.forward, direction),
    );
}

// position: of the photograph's frame.
fn seen_at(position: vec3<f32>) -> Projected {
    var found: Projected;
    found.position = position;
    found.normalised = found.position.xy * (1.0 / found.position.z);
    var lens = photograph.lens;
    lens.model = LENS_MODEL;
    let raw = lens_pixel(lens, found.normalised);
    found.pixel = raw.xy;
    let inside = min(raw.xy, lens.size - raw.xy);
    let border = min(inside.x, inside.y) / min(lens.size.x, lens.size.y);
    let in_map = max(abs(found.normalised.x), abs(found.normalised.y)) < MAX_TANGENT;
    let sees = raw.z == 1.0 && in_map && found.position.z >= NEAREST_DEPTH_M && border > 0.0;
    found.border = select(0.0, border, sees);
    return found;
}

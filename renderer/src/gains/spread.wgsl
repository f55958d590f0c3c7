// Places that a photograph sees, spread evenly over its depth map. Needs lens.wgsl,
// photograph.wgsl, agree.wgsl and known.wgsl.

// Width of what is averaged around a place, as a share of its depth: some 16 texels of a
// photograph a thousand wide, so that what lies off by a texel or two changes little.
const FOOTPRINT: f32 = 0.03;
// Nothing is known beyond this, metres.
const BEYOND_M: f32 = 1e6;

// Position, and the width of what is averaged, metres; 0 where there is no place.
@group(0) @binding(6) var<storage, read_write> places: array<vec4<f32>>;

// One invocation a place: the grid is as large as what is dispatched.
@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    photograph = given;
    let grid = 8u * groups.xy;
    let at = (vec2<f32>(id.xy) + 0.5) / vec2<f32>(grid);
    let texel = vec2<i32>(at * vec2<f32>(photograph.map_size));
    let z = known_at(texel).x;
    let reach = i32(ceil(0.5 * FOOTPRINT * photograph.map_focal.x));
    let whole = z < BEYOND_M
        && is_same_surface(z, known_at(texel + vec2(reach, 0)))
        && is_same_surface(z, known_at(texel - vec2(reach, 0)))
        && is_same_surface(z, known_at(texel + vec2(0, reach)))
        && is_same_surface(z, known_at(texel - vec2(0, reach)));
    let m = (vec2<f32>(texel) + 0.5 - photograph.map_centre) / photograph.map_focal;
    let ray = photograph.right * m.x + photograph.down * m.y + photograph.forward;
    let place = vec4(photograph.centre + z * ray, FOOTPRINT * z);
    places[id.y * grid.x + id.x] = select(vec4(0.0), place, whole);
}

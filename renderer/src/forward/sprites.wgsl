// The sprites of the points that pixels show, and their colour in a photograph. Needs
// colour.wgsl, camera.wgsl, plane.wgsl and homography.wgsl.

// Mirrors `View` in forward/mod.rs.
struct View {
    camera: Camera,
    // Words between the indices of two pixels.
    index_stride: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

// As gather.wgsl leaves them.
const ALONE: u32 = 0x80000000u;

@group(0) @binding(2) var orientations: texture_2d<u32>;
@group(3) @binding(0) var<uniform> view: View;
@group(3) @binding(1) var winners: texture_2d<u32>;
@group(3) @binding(2) var winning_normals: texture_2d<u32>;
@group(3) @binding(3) var planes: texture_2d<f32>;
@group(3) @binding(4) var<storage, read> indices: array<u32>;
@group(3) @binding(5) var<storage, read> sprites: array<u32>;
@group(3) @binding(6) var<storage, read> reaches: array<u32>;

struct Sprite {
    home: vec2<u32>,
    // Its box, pixels from the centre of its home.
    low: vec2<f32>,
    high: vec2<f32>,
    homography: mat3x4<f32>,
    // What its pixels hold: index of the point, with HAS_NO_RELIEF; orientation.
    key: vec3<u32>,
    // Whether the photograph may see any of it.
    seen: bool,
}

const HAS_NO_RELIEF: u32 = 0x80000000u;

fn sprite_of(instance: u32) -> Sprite {
    let word = sprites[instance];
    let pixel = word & ~ALONE;
    var sprite: Sprite;
    sprite.home = vec2(pixel % view.camera.size.x, pixel / view.camera.size.x);
    sprite.low = vec2(-0.5);
    sprite.high = vec2(0.5);
    if (word & ALONE) == 0u {
        let reach = vec3(reaches[3u * pixel], reaches[3u * pixel + 1u], reaches[3u * pixel + 2u]);
        sprite.low.x -= f32(reach.x);
        sprite.high += vec2<f32>(reach.yz);
    }
    let flags = textureLoad(positions, sprite.home, 0).w;
    let orientation = textureLoad(orientations, sprite.home, 0).xy;
    sprite.key = vec3(
        indices[pixel * view.index_stride] | select(HAS_NO_RELIEF, 0u, (flags & HAS_RELIEF) != 0u),
        orientation,
    );
    let p = bitcast<vec3<f32>>(textureLoad(winners, sprite.home, 0).xyz);
    let n = exact_normal(orientation.x, p, sprite.home);
    let plane = plane_through(p, n);
    let turn = transpose(mat3x3(photograph.right, photograph.down, photograph.forward));
    let e = turn * -photograph.centre;
    let centre = vec2<f32>(sprite.home) + 0.5;
    sprite.homography = homography(view.camera, centre, plane, turn, e);
    sprite.seen = any(plane != vec3(0.0)) && may_see(sprite);
    return sprite;
}

// The normal that was rounded to this code: that of the point's disc or of the mesh.
fn exact_normal(code: u32, p: vec3<f32>, cell: vec2<u32>) -> vec3<f32> {
    let mesh = textureLoad(planes, cell, 0).xyz;
    var disc = facing(view.camera, p);
    let normal_code = textureLoad(winning_normals, cell, 0).x;
    if normal_code != 0u {
        disc = normalize(disc_normal(disc, from_octahedral(normal_code)));
    }
    if octahedral(disc) == code {
        return disc;
    }
    // Where rounding fell the other way for a disc, its code is off by no more than that.
    return select(from_octahedral(code), mesh, octahedral(mesh) == code);
}

// False where a side of the photograph's pyramid has all of the box behind it: H is linear, so
// that its corners decide.
fn may_see(sprite: Sprite) -> bool {
    let low = -photograph.map_centre / photograph.map_focal;
    let high = (vec2<f32>(photograph.map_size) - photograph.map_centre) / photograph.map_focal;
    var left_top = vec2(false);
    var right_bottom = vec2(false);
    for (var corner = 0u; corner < 4u; corner++) {
        let h = (sprite.homography * vec3(box_corner(sprite, corner), 1.0)).xyz;
        left_top |= h.xy > low * h.z;
        right_bottom |= h.xy < high * h.z;
    }
    return all(left_top & right_bottom);
}

// Of a strip of four, from the home's centre.
fn box_corner(sprite: Sprite, corner: u32) -> vec2<f32> {
    return select(sprite.low, sprite.high, vec2((corner & 1u) == 1u, corner > 1u));
}

// Where a strip's corner is drawn. What is not seen is drawn nowhere.
fn clip_position(sprite: Sprite, corner: u32) -> vec4<f32> {
    let pixel = vec2<f32>(sprite.home) + 0.5 + box_corner(sprite, corner);
    let ndc = 2.0 * pixel / frame.size - 1.0;
    return select(vec4(0.0, 0.0, -1.0, 1.0), vec4(ndc.x, -ndc.y, 0.0, 1.0), sprite.seen);
}

fn is_own_pixel(cell: vec2<u32>, key: vec3<u32>) -> bool {
    let index = indices[(cell.y * view.camera.size.x + cell.x) * view.index_stride];
    return index == (key.x & ~HAS_NO_RELIEF)
        && all(textureLoad(orientations, cell, 0).xy == key.yz);
}

// h: what the homography gives.
fn colour_at(h: vec4<f32>, key: vec3<u32>, cell: vec2<u32>) -> vec4<f32> {
    var place: Place;
    place.kind = SHOWS_POINT;
    place.normal = from_octahedral(key.y);
    place.relief_m = select(RELIEF_M, 0.0, (key.x & HAS_NO_RELIEF) != 0u);
    place.code = key.z;
    let view_depth = 1.0 / h.w;
    let colour = weighted_colour(place, seen_at(h.xyz * view_depth), view_depth);
    // Planes that the ray meets behind the eye, or nowhere, show nothing.
    return heard_at(select(vec4(0.0), colour, h.w > 0.0), vec2<i32>(cell));
}

// One output pixel at a time: which surface it shows, and what the photographs say about it.
// Needs camera.wgsl, lens.wgsl, depth_map.wgsl and blend.wgsl.

// Mirrors `gpu_data::Frame` in shade/mod.rs.
struct Frame {
    // The pinhole of the G-buffer; positions are relative to its centre, the eye.
    camera: Camera,
    // The lens of the picture. Model 0: the pinhole itself.
    lens: Lens,
    // sRGB, 0 to 1.
    background: vec3<f32>,
    photograph_count: u32,
    // Nodes a row of `grid`, pixels between them.
    grid_columns: u32,
    grid_step: f32,
    map_side: u32,
    tile_columns: u32,
}

// Mirrors `gpu_data::Photograph` in shade/mod.rs.
struct Photograph {
    lens: Lens,
    // Rows of cam_from_world.
    right: vec3<f32>,
    rig: u32,
    down: vec3<f32>,
    map_layer: u32,
    forward: vec3<f32>,
    // Squared distance from the eye, metres.
    eye_distance_2: f32,
    // Relative to the eye.
    centre: vec3<f32>,
    atlas: u32,
    map_focal: vec2<f32>,
    map_centre: vec2<f32>,
    map_size: vec2<u32>,
    layer: u32,
    max_lod: f32,
    corner: vec2<f32>,
    // One over the side of the atlas layer.
    texel: f32,
    padding: u32,
}

struct Place {
    kind: u32, // of SHOWS_*
    position: vec3<f32>,
    normal: vec3<f32>,
    depth: f32,
    // Uncertainty of mesh.
    delta: f32,
    // How far points of the same surface may stand out of its plane, see depth_map.wgsl.
    relief_m: f32,
    // Class of mesh, code of a point.
    code: u32,
}

// Which atlases hold a photograph of this frame: code for the others is left out, because
// software devices run every branch.
override uses_atlas_0: bool = true;
override uses_atlas_1: bool = true;
override uses_atlas_2: bool = true;
override uses_atlas_3: bool = true;

// Pixels a side of a tile, see shade/tiles.rs.
const TILE: u32 = 64u;
const SHOWS_NOTHING: u32 = 0u;
const SHOWS_MESH: u32 = 1u;
const SHOWS_POINT: u32 = 3u;
const NONE: u32 = 0xffffffffu;
const NOWHERE: f32 = 1e29;
// Points this near to a mesh are its surface however certain the mesh is, metres: waves and
// kerbs that a grid of terrain does not follow.
const SAME_SURFACE_M: f32 = 0.15;
// Noise between drives, and discs that do not lie in their surface, metres.
const RELIEF_M: f32 = 0.1;
// Filtered masks this close to one have no masked texel in them.
const OPAQUE: f32 = 0.999;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var planes: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<u32>;
@group(0) @binding(3) var winners: texture_2d<u32>;
@group(0) @binding(4) var<storage, read> indices: array<u32>;
@group(0) @binding(5) var<storage, read> photographs: array<Photograph>;
@group(0) @binding(6) var map_mesh: texture_2d_array<f32>;
@group(0) @binding(7) var<storage, read> map_points: array<u32>;
@group(0) @binding(8) var<storage, read> grid: array<vec2<f32>>;
@group(0) @binding(9) var<storage, read_write> picture: array<u32>;
@group(0) @binding(10) var filtering: sampler;
@group(0) @binding(11) var atlas_0: texture_2d_array<f32>;
@group(0) @binding(12) var atlas_1: texture_2d_array<f32>;
@group(0) @binding(13) var atlas_2: texture_2d_array<f32>;
@group(0) @binding(14) var atlas_3: texture_2d_array<f32>;

// For each tile a row of photograph_count + 1 words: how many photographs can see something of
// it, and which.
@group(0) @binding(15) var<storage, read> tiles: array<u32>;

@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<u32>(frame.lens.size);
    if any(id.xy >= size) {
        return;
    }
    let pixel = vec2<f32>(id.xy) + 0.5;
    let m = direction(pixel);
    var colour = frame.background;
    var surface = SHOWS_NOTHING;
    if m.z > 0.0 {
        let place = place_on(m.xy);
        if place.kind != SHOWS_NOTHING {
            let tile = id.y / TILE * frame.tile_columns + id.x / TILE;
            let blended = blend(place, tile * (frame.photograph_count + 1u));
            if blended.w > 0.0 {
                colour = srgb_from_linear(blended.rgb / blended.w);
                surface = place.kind + 1u;
            } else {
                colour = own_colour(place);
                surface = place.kind;
            }
        }
    }
    let bytes = vec4<u32>(vec4(round(colour * 255.0), f32(surface)));
    picture[id.y * size.x + id.x] =
        bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (bytes.w << 24u);
}

// Normalised direction that a raw pixel position sees; z is 0 where it sees none.
fn direction(pixel: vec2<f32>) -> vec3<f32> {
    let lens = frame.lens;
    if lens.model == 0u {
        return vec3((pixel - lens.centre) / lens.focal, 1.0);
    }
    let at = pixel / frame.grid_step;
    let node = floor(at);
    let t = at - node;
    let first = u32(node.y) * frame.grid_columns + u32(node.x);
    let nw = grid[first];
    let ne = grid[first + 1u];
    let sw = grid[first + frame.grid_columns];
    let se = grid[first + frame.grid_columns + 1u];
    if max(max(nw.x, ne.x), max(sw.x, se.x)) > NOWHERE {
        return vec3(0.0);
    }
    let m = mix(mix(nw, ne, t.x), mix(sw, se, t.x), t.y);
    // One Newton step, with the slope of the interpolation.
    let dx = mix(ne - nw, se - sw, t.y) / frame.grid_step;
    let dy = mix(sw - nw, se - ne, t.x) / frame.grid_step;
    let missed = pixel - lens_pixel(lens, m).xy;
    return vec3(m + dx * missed.x + dy * missed.y, 1.0);
}

// The surface that the ray through the normalised position m meets, by the hybrid rule: the
// mesh occludes from its far surface, delta behind it; within delta a point replaces it.
fn place_on(m: vec2<f32>) -> Place {
    var place: Place;
    let position = frame.camera.focal * m + frame.camera.centre;
    let cell = vec2<i32>(floor(position));
    if any(cell < vec2(0)) || any(cell >= vec2<i32>(frame.camera.size)) {
        return place;
    }
    let ray = world_from_cam(frame.camera, vec3(m, 1.0));
    let cell_ray = world_from_cam(
        frame.camera,
        ray_from_pixel(frame.camera, vec2<f32>(cell) + 0.5),
    );
    let surface = textureLoad(surfaces, cell, 0).x;
    var mesh_depth = NOTHING_M;
    if surface != 0u {
        let plane = textureLoad(planes, cell, 0);
        let at_centre = plane.w / dot(plane.xyz, cell_ray);
        let exact = plane.w / dot(plane.xyz, ray);
        // Seen nearly edge-on, the plane may run away within a pixel.
        mesh_depth = select(at_centre, exact, exact > 0.5 * at_centre && exact < 2.0 * at_centre);
        place.kind = SHOWS_MESH;
        place.depth = mesh_depth;
        place.normal = plane.xyz;
        place.delta = unpack2x16float(surface).x;
        place.relief_m = max(place.delta, RELIEF_M);
        place.code = (surface >> 16u) - 1u;
    }
    if indices[u32(cell.y) * frame.camera.size.x + u32(cell.x)] != NONE {
        let winner = textureLoad(winners, cell, 0);
        let p = bitcast<vec3<f32>>(winner.xyz);
        let depth = dot(p, p) / dot(p, cell_ray);
        if place.kind == SHOWS_NOTHING || depth <= mesh_depth + place.delta {
            place = point_place(p, winner.w, ray, place);
        }
    }
    place.position = ray * place.depth;
    return place;
}

// The point p where the mesh behind is `mesh`. A point near the mesh is that surface, better
// known: it has the mesh's orientation. Any other faces the eye.
fn point_place(p: vec3<f32>, code: u32, ray: vec3<f32>, mesh: Place) -> Place {
    var place: Place;
    place.kind = SHOWS_POINT;
    place.depth = dot(p, p) / dot(p, ray);
    place.normal = -normalize(p);
    place.code = code;
    if mesh.kind == SHOWS_MESH {
        let off_plane = dot(mesh.normal, p - ray * mesh.depth);
        let depth = dot(mesh.normal, p) / dot(mesh.normal, ray);
        let near_disc = depth > 0.8 * place.depth && depth < 1.25 * place.depth;
        if abs(off_plane) <= max(mesh.delta, SAME_SURFACE_M) && near_disc {
            place.depth = depth;
            place.normal = mesh.normal;
            place.relief_m = RELIEF_M;
        }
    }
    return place;
}

// Sum of weighted linear colours, and of weights. Of each rig one camera has its say: the one
// that sees the place farthest from its border, or the one the eye is in.
fn blend(place: Place, tile: u32) -> vec4<f32> {
    var sum = vec4(0.0);
    var best = vec4(0.0);
    var best_score = 0.0;
    var rig = NONE;
    let end = tile + tiles[tile];
    for (var entry = tile + 1u; entry <= end; entry++) {
        let i = tiles[entry];
        if photographs[i].rig != rig {
            sum += best;
            best = vec4(0.0);
            best_score = 0.0;
            rig = photographs[i].rig;
        }
        let from_centre = place.position - photographs[i].centre;
        let z = dot(photographs[i].forward, from_centre);
        if z < frame.camera.near {
            continue;
        }
        let c = vec3(
            dot(photographs[i].right, from_centre),
            dot(photographs[i].down, from_centre),
            z,
        );
        let m = c.xy / z;
        let raw = lens_pixel(photographs[i].lens, m);
        let inside = min(raw.xy, photographs[i].lens.size - raw.xy);
        let border = min(inside.x, inside.y)
            / min(photographs[i].lens.size.x, photographs[i].lens.size.y);
        let score = rig_score(border, photographs[i].eye_distance_2);
        if raw.z == 0.0 || !(score > best_score) {
            continue;
        }
        let distance_2 = dot(from_centre, from_centre);
        let cosine = -dot(place.normal, from_centre) * inverseSqrt(distance_2);
        if !(cosine > 0.0) {
            continue;
        }
        let seen = edge_weight(visible_share(i, place, c, m));
        if seen <= 0.0 {
            continue;
        }
        let texel = look_up(i, raw.xy, level_of_detail(i, z, place.depth));
        if texel.a < OPAQUE {
            continue;
        }
        let weight = park_weight(cosine, distance_2, photographs[i].eye_distance_2)
            * feather_weight(border) * seen;
        best = vec4(texel.rgb * weight, weight);
        best_score = score;
    }
    return sum + best;
}

// Share, by bilinear weight, of the four texels around the place that see it.
fn visible_share(i: u32, place: Place, c: vec3<f32>, m: vec2<f32>) -> f32 {
    let focal = photographs[i].map_focal;
    let centre = photographs[i].map_centre;
    let at = focal * m + centre - 0.5;
    let first = floor(at);
    let t = at - first;
    let texel_m = c.z / min(focal.x, focal.y);
    let n = vec3(
        dot(photographs[i].right, place.normal),
        dot(photographs[i].down, place.normal),
        dot(photographs[i].forward, place.normal),
    );
    let limit = vec2<i32>(photographs[i].map_size) - 1;
    let layer = photographs[i].map_layer;
    var share = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let step = vec2<f32>(vec2(corner & 1u, corner >> 1u));
        let texel = first + step;
        let ray = vec3((texel + 0.5 - centre) / focal, 1.0);
        let z = depth_on_texel_ray(c, n, ray);
        let relief = relief_depth(place.relief_m, n, ray);
        let cell = clamp(vec2<i32>(texel), vec2(0), limit);
        var occluders: Occluders;
        occluders.mesh = textureLoad(map_mesh, cell, layer, 0).xy;
        let word = (layer * frame.map_side + u32(cell.y)) * frame.map_side + u32(cell.x);
        let bits = map_points[word];
        occluders.point = select(bitcast<f32>(bits), NOTHING_M, bits == NONE);
        if is_visible(z, texel_m, place.kind == SHOWS_POINT, relief, occluders) {
            let weight = mix(1.0 - t, t, step);
            share += weight.x * weight.y;
        }
    }
    return share;
}

// How many times the photograph's texels must be halved to match the picture's pixels there.
fn level_of_detail(i: u32, photograph_depth: f32, view_depth: f32) -> f32 {
    let texels_per_m = photographs[i].lens.focal.y / photograph_depth;
    let pixels_per_m = frame.lens.focal.y / view_depth;
    let lod = log2(max(texels_per_m / pixels_per_m, 1.0));
    // So little is rounding: the full level alone is exact.
    return select(min(lod, photographs[i].max_lod), 0.0, lod < 0.02);
}

// Filtered linear colour and mask at a raw pixel position.
fn look_up(i: u32, pixel: vec2<f32>, lod: f32) -> vec4<f32> {
    // Half a texel inside, at the coarser of the levels that are filtered.
    let inset = vec2(0.5 * exp2(ceil(lod)));
    let size = photographs[i].lens.size;
    let inside = clamp(pixel, inset, max(size - inset, inset));
    let uv = (photographs[i].corner + inside) * photographs[i].texel;
    let layer = photographs[i].layer;
    let atlas = photographs[i].atlas;
    var texel = vec4(0.0);
    if uses_atlas_0 && atlas == 0u {
        texel = textureSampleLevel(atlas_0, filtering, uv, layer, lod);
    }
    if uses_atlas_1 && atlas == 1u {
        texel = textureSampleLevel(atlas_1, filtering, uv, layer, lod);
    }
    if uses_atlas_2 && atlas == 2u {
        texel = textureSampleLevel(atlas_2, filtering, uv, layer, lod);
    }
    if uses_atlas_3 && atlas == 3u {
        texel = textureSampleLevel(atlas_3, filtering, uv, layer, lod);
    }
    return texel;
}

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
        case 0u: { return vec3(0.50, 0.50, 0.48) * lit; }
        case 1u: { return vec3(0.66, 0.65, 0.62) * lit; }
        default: { return vec3(0.60, 0.56, 0.54) * lit; }
    }
}

// IEC 61966-2-1.
fn srgb_from_linear(linear: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(max(linear, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055;
    return clamp(select(curve, 12.92 * linear, linear <= vec3(0.0031308)), vec3(0.0), vec3(1.0));
}

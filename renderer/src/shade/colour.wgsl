// What one photograph says about a place, wherever its projection comes from: weighted linear
// colour, and the weight. Needs photograph.wgsl, texel.wgsl, place.wgsl, point.wgsl, depth_map.wgsl and
// blend.wgsl.

@group(0) @binding(3) var map_mesh: texture_2d_array<f32>;
@group(0) @binding(4) var map_points: texture_2d_array<f32>;
@group(0) @binding(8) var unfiltered: sampler;

const MODE_SOURCES: u32 = 7u;
// Where the corners 00, 10, 01 and 11 are among those that are gathered.
const GATHERED: vec4<u32> = vec4(3u, 2u, 0u, 1u);

// place: of it, kind, normal and relief. view_depth: along the view's axis, metres.
fn weighted_colour(place: Place, seen: Projected, view_depth: f32) -> vec4<f32> {
    let n = turned(place.normal);
    let distance_2 = dot(seen.position, seen.position);
    // No branch on a uniform: Mesa's software driver compiles a shader that has one anew, and
    // keeps it, at every draw with another value of any uniform.
    let visible = select(1.0, visible_share(place, n, seen), frame.depth_test == 1u);
    let cosine = -dot(n, seen.position) * inverseSqrt(max(distance_2, 1e-12));
    let texel = look_up(seen.pixel, level_of_detail(seen.position.z, view_depth));
    let weight = park_weight(cosine, distance_2, photograph.eye_distance_2)
        * feather_weight(seen.border * photograph.closeness)
        * mask_weight(texel.a)
        * edge_weight(visible)
        * photograph.rig_weight;
    let colour = select(texel.rgb * photograph.gain, photograph.mark, frame.mode == MODE_SOURCES);
    return select(vec4(0.0), vec4(colour * weight, weight), weight > 0.0);
}

// Share, by bilinear weight, of the four texels around the place that see it. n: its normal in
// the photograph's frame.
fn visible_share(place: Place, n: vec3<f32>, seen: Projected) -> f32 {
    let focal = photograph.map_focal;
    let centre = photograph.map_centre;
    let at = focal * seen.normalised + centre - 0.5;
    let first = floor(at);
    let t = at - first;
    let texel_m = seen.position.z / min(focal.x, focal.y);
    let bias = depth_bias(texel_m, photograph.pose_m, n, vec3(seen.normalised, 1.0));
    // Maps have a margin, so that what is seen has all four texels in them.
    let cell = clamp(first, vec2(0.0), vec2<f32>(photograph.map_size) - 2.0);
    let between = (cell + 1.0) / vec2<f32>(textureDimensions(map_mesh));
    let layer = photograph.map_layer;
    let mesh = textureGather(0, map_mesh, unfiltered, between, layer);
    let delta = textureGather(1, map_mesh, unfiltered, between, layer);
    let point = textureGather(0, map_points, unfiltered, between, layer);
    let c = seen.position;
    var share = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let step = vec2<f32>(vec2(corner & 1u, corner >> 1u));
        let texel = first + step;
        let ray = vec3((texel + 0.5 - centre) / focal, 1.0);
        let z = depth_on_texel_ray(c, n, ray);
        let relief = relief_depth(place.relief_m, n, ray);
        // Gathered counterclockwise from the lower left.
        let i = GATHERED[corner];
        let occluders = Occluders(vec2(mesh[i], delta[i]), point_depth(point[i]));
        let weight = mix(1.0 - t, t, step);
        let visible = visibility(z, bias, place.kind == SHOWS_POINT, relief, occluders);
        share += weight.x * weight.y * visible;
    }
    return share;
}

// How many times the photograph's texels must be halved to match the picture's pixels there.
fn level_of_detail(photograph_depth: f32, view_depth: f32) -> f32 {
    let texels_per_m = photograph.lens.focal.y / photograph_depth;
    let metres_per_pixel = select(view_depth, 1.0, frame.orthographic == 1u) / frame.focal;
    let lod = log2(max(texels_per_m * metres_per_pixel, 1.0));
    // So little is rounding: the full level alone is exact.
    return select(min(lod, photograph.max_lod), 0.0, lod < 0.02);
}

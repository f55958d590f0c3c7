// What one photograph says about a place, wherever its projection comes from: weighted linear
// colour, and the weight. Needs photograph.wgsl, texel.wgsl, place.wgsl, point.wgsl, depth_map.wgsl,
// blend.wgsl and heard.wgsl.

// Two layers a map: depth, and that of points that are still the mesh.
@group(0) @binding(3) var map_mesh: texture_2d_array<f32>;
@group(0) @binding(4) var map_points: texture_2d_array<f32>;
// The weight of what the nearest rigs have said, see limit.wgsl.
@group(0) @binding(7) var said: texture_2d<f32>;

// Whether they have spoken before.
override OF_REST: bool = false;

// Fewer texels a pixel than these are rounding: the full level alone is exact.
const LEAST_TEXELS_PER_PIXEL: f32 = 1.015;
// Share of its distance from the eye by which an inferred place may be off.
const INFERRED_OFF: f32 = 0.2;

// place: of it, kind, normal and relief. view_depth: as `view_depth_of` has it.
fn weighted_colour(place: Place, seen: Projected, view_depth: f32) -> vec4<f32> {
    let n = turned(place.normal);
    let distance_2 = dot(seen.position, seen.position);
    // No branch on a uniform: Mesa's software driver compiles a shader that has one anew, and
    // keeps it, at every draw with another value of any uniform.
    let visible = select(1.0, visible_share(place, n, seen), eye.tests_depth);
    let cosine = -dot(n, seen.position) * inverseSqrt(max(distance_2, 1e-12));
    let texels = max(texels_per_pixel(seen.position.z, view_depth), texels_off(place, seen));
    let texel = look_up(seen.pixel, min(texels, photograph.max_texels));
    let weight = park_weight(cosine, distance_2, photograph.eye_distance_2)
        * feather_weight(seen.border * photograph.closeness)
        * mask_weight(texel.a)
        * edge_weight(visible)
        * photograph.rig_weight;
    let colour = select(texel.rgb * photograph.gain, photograph.mark, eye.shows_marks);
    return select(vec4(0.0), vec4(colour * weight, weight), weight > 0.0);
}

// What is heard of a weighted colour in a pixel of the picture.
fn heard_at(colour: vec4<f32>, cell: vec2<i32>) -> vec4<f32> {
    if OF_REST {
        return heard(colour, textureLoad(said, cell, 0).x);
    }
    return colour;
}

// Share, by bilinear weight, of the four texels around the place that see it. n: its normal in
// the photograph's frame.
fn visible_share(place: Place, n: vec3<f32>, seen: Projected) -> f32 {
    let centre = photograph.map_centre;
    let at = photograph.map_focal * seen.normalised + centre - 0.5;
    let first = floor(at);
    let t = at - first;
    let per_focal = 1.0 / photograph.map_focal;
    let texel_m = seen.position.z * max(per_focal.x, per_focal.y);
    let bias = depth_bias(texel_m, photograph.pose_m, n, vec3(seen.normalised, 1.0));
    // Maps have a margin, so that what is seen has all four texels in them.
    let between = (first + 1.0) * photograph.map_texel;
    let layer = photograph.map_layer;
    let of_kind = 2u * layer + select(0u, 1u, place.kind == SHOWS_POINT);
    let mesh = textureGather(0, map_mesh, unfiltered, between, of_kind);
    let point = textureGather(0, map_points, unfiltered, between, layer);
    let occluders = Occluders(mesh, point_depths(point));
    // Counterclockwise from the lower left, as they are gathered.
    let low = (first + 0.5 - centre) * per_focal;
    let high = low + per_focal;
    let across = 1.0 / (n.x * vec4(low.x, high.x, high.x, low.x)
        + (n.y * vec4(high.y, high.y, low.y, low.y) + n.z));
    let z = depths_on_texel_rays(seen.position, n, across);
    let relief = relief_depths(place.relief_m, across);
    let visible = visibilities(z, bias, relief, occluders);
    let u = 1.0 - t;
    return dot(vec4(u.x, t.x, t.x, u.x) * vec4(t.y, t.y, u.y, u.y), visible);
}

// How many texels of the photograph's full level it may be off where it sees a place of unsure depth:
// it is asked what it shows on the whole there. Equation in shade/reference.rs.
fn texels_off(place: Place, seen: Projected) -> f32 {
    let share = select(0.0, INFERRED_OFF, place.kind == SHOWS_INFERRED);
    let centre = turned(photograph.centre);
    let moved = length(centre.xy - seen.normalised * centre.z);
    return share * photograph.lens.focal.y * moved / seen.position.z;
}

// Depth of a place along the view's axis, metres; 1 at any depth of an orthographic view, where all
// are as large as at that.
fn view_depth_of(place: vec3<f32>) -> f32 {
    return dot(eye.axis.xyz, place) + eye.axis.w;
}

// How many texels of the photograph's full level are a pixel of the picture there, one at least and
// those of its coarsest level at most.
fn texels_per_pixel(photograph_depth: f32, view_depth: f32) -> f32 {
    let texels = eye.texels_per_pixel * view_depth / photograph_depth;
    // So little is rounding: the full level alone is exact.
    return select(min(texels, photograph.max_texels), 1.0, texels < LEAST_TEXELS_PER_PIXEL);
}

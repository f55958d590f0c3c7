// What one photograph shows where the hypotheses of all cells would be, as places.wgsl has them
// in `positions`. Needs colour.wgsl, brightness.wgsl and inference.wgsl.

struct Sight {
    // Ranks the cameras of a rig.
    @builtin(frag_depth) rank: f32,
    // Brightness less that of its surroundings; 1 where the photograph sees the place.
    @location(0) seen: vec2<f32>,
}

// Surroundings reach so many cells to all sides, so that exposure, which changes between
// photographs, cancels, and patterns stay.
const REACH: f32 = 3.0;
// Texels of theirs are so many times as wide as of what they surround, where there are such levels.
const COARSER: f32 = 4.0;

@group(0) @binding(6) var<uniform> inference: Inference;

@vertex
fn tile(@builtin(vertex_index) index: u32, @location(0) tile: u32) -> Corner {
    let rows = inference.cells.y * inference.hypotheses;
    return corner_of(tile, index, vec2<f32>(vec2(inference.cells.x, rows)));
}

@fragment
fn fs(corner: Corner) -> Sight {
    take(corner);
    let at = corner.position;
    let shown = textureLoad(positions, vec2<i32>(at.xy), 0);
    let place = bitcast<vec3<f32>>(shown.xyz);
    let found = projected(place);
    let view_depth = max(view_depth_of(place), 1e-3);
    let texels = texels_per_pixel(found.position.z, view_depth) * f32(inference.step);
    let texel = look_up(found.pixel, texels);
    let reach = REACH * texels;
    var around = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let towards = 2.0 * vec2<f32>(vec2(i & 1u, i >> 1u)) - 1.0;
        around += 0.25 * brightness(look_up(found.pixel + reach * towards, COARSER * texels).rgb);
    }
    var sight: Sight;
    sight.seen = vec2(brightness(texel.rgb) - around, 1.0);
    let rank = rig_score(found.border, photograph.closeness);
    sight.rank = select(0.0, rank, texel.a >= OPAQUE && shown.w != 0u);
    return sight;
}

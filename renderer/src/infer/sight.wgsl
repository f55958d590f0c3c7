// What one photograph shows where the hypotheses of all cells would be: those of the backdrop
// first, then those of the next, one below the other. Needs colour.wgsl,
// brightness.wgsl and inference.wgsl.

struct Sight {
    // Ranks the cameras of a rig.
    @builtin(frag_depth) rank: f32,
    // Brightness less that of its surroundings; 1 where the photograph sees the place.
    @location(0) seen: vec2<f32>,
}

// Surroundings reach so many cells to all sides, so that exposure, which changes between
// photographs, cancels, and patterns stay.
const REACH: f32 = 3.0;
// Times that they are halved more often than what they surround, where there are such levels.
const COARSER: f32 = 2.0;

@group(0) @binding(6) var<uniform> inference: Inference;
@group(0) @binding(7) var rays: texture_2d<f32>;
@group(0) @binding(8) var diffused: texture_2d<f32>;

@vertex
fn whole(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle over the viewport.
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Sight {
    let tall = vec2<u32>(at.xy);
    let index = tall.y / inference.cells.y;
    let cell = vec2<i32>(vec2(tall.x, tall.y % inference.cells.y));
    var sight: Sight;
    let direction = textureLoad(rays, cell, 0);
    // What is known is not judged, so that nobody need look.
    if direction.w > 0.5 {
        return sight;
    }
    let ray = direction.xyz;
    let inverse = hypothesis(inference, f32(index), textureLoad(diffused, cell, 0).x);
    let place = ray / max(inverse, 1e-9);
    let found = projected(place);
    let rank = rig_score(found.border, photograph.closeness);
    let view_depth = max(dot(frame.forward, place), 1e-3);
    let lod = level_of_detail(found.position.z, view_depth) + log2(f32(inference.step));
    let coarse = min(lod + COARSER, photograph.max_lod);
    let texel = look_up(found.pixel, min(lod, photograph.max_lod));
    let reach = REACH * exp2(lod);
    var around = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let corner = 2.0 * vec2<f32>(vec2(i & 1u, i >> 1u)) - 1.0;
        around += 0.25 * brightness(look_up(found.pixel + reach * corner, coarse).rgb);
    }
    sight.seen = vec2(brightness(texel.rgb) - around, 1.0);
    sight.rank = select(0.0, rank, texel.a >= OPAQUE && dot(ray, ray) > 0.0);
    return sight;
}

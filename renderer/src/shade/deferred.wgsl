// What one photograph says about the pixels where it is the best of its rig, by projecting what
// they show. Needs colour.wgsl.

@group(0) @binding(2) var orientations: texture_2d<u32>;
@group(0) @binding(5) var filtering: sampler;
@group(0) @binding(6) var offsets: texture_2d<f32>;

// Whether points are left to sprites.
override POINTS_APART: bool = false;
// Whether the photograph is displaced by the offsets on which it agrees with another.
override ALIGNED: bool = false;

@fragment
fn fs(corner: Corner) -> @location(0) vec4<f32> {
    take(corner);
    let at = corner.position;
    let cell = vec2<i32>(at.xy);
    let orientation = textureLoad(orientations, cell, 0).xy;
    let place = unpacked(textureLoad(positions, cell, 0), orientation);
    if POINTS_APART && place.kind == SHOWS_POINT {
        discard;
    }
    let depth = view_depth_of(place.position);
    var seen = projected(place.position);
    if ALIGNED {
        let cells = at.xy / (photograph.shift_step * vec2<f32>(textureDimensions(offsets)));
        let offset = photograph.shift * depth * textureSampleLevel(offsets, filtering, cells, 0.0);
        // What it sees of the place stays what it was; only where that is found is displaced.
        seen.pixel = projected(place.position + offset.xyz).pixel;
    }
    let colour = heard_at(weighted_colour(place, seen, depth), cell);
    // Tiles that a photograph has to itself are drawn whole.
    return select(vec4(0.0), colour, place.kind != SHOWS_NOTHING);
}

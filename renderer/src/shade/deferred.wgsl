// What one photograph says about the pixels where it is the best of its rig, by projecting what
// they show. Needs colour.wgsl.

@group(0) @binding(2) var orientations: texture_2d<u32>;

// Whether points are left to sprites.
override POINTS_APART: bool = false;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let cell = vec2<i32>(at.xy);
    let orientation = textureLoad(orientations, cell, 0).xy;
    let place = unpacked(textureLoad(positions, cell, 0), orientation);
    if POINTS_APART && place.kind == SHOWS_POINT {
        discard;
    }
    let colour =
        weighted_colour(place, projected(place.position), dot(frame.forward, place.position));
    // Tiles that a photograph has to itself are drawn whole.
    return select(vec4(0.0), colour, place.kind != SHOWS_NOTHING);
}

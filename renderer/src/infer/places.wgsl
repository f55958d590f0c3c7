// Where the hypotheses of all cells lie: those of the backdrop first, then those of the next, one
// below the other; nothing where no hypothesis is judged. Needs octahedral.wgsl, place.wgsl,
// inference.wgsl and screen.wgsl.

@group(0) @binding(0) var<uniform> inference: Inference;
@group(0) @binding(1) var rays: texture_2d<f32>;
@group(0) @binding(2) var diffused: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<u32> {
    let tall = vec2<u32>(at.xy);
    let index = tall.y / inference.cells.y;
    let cell = vec2<i32>(vec2(tall.x, tall.y % inference.cells.y));
    let ray = textureLoad(rays, cell, 0);
    let inverse = hypothesis(inference, f32(index), textureLoad(diffused, cell, 0).x);
    var place: Place;
    place.position = ray.xyz / max(inverse, 1e-9);
    // What is known is not judged, and what no lens sees has no place.
    let judged = ray.w <= 0.5 && dot(ray.xyz, ray.xyz) > 0.0;
    place.kind = select(SHOWS_NOTHING, SHOWS_INFERRED, judged);
    return packed_position(place, false);
}

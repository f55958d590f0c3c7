// The colours that one photograph shows of the places that it sees. Needs lens.wgsl,
// photograph.wgsl, agree.wgsl, known.wgsl and texel.wgsl.

@group(0) @binding(6) var<storage, read> places: array<vec4<f32>>;
// Linear red, green, blue and 1, sixteen bits each; 0 where the photograph does not see the place.
@group(0) @binding(7) var<storage, read_write> samples: array<vec2<u32>>;

// Least width, in texels, of what is averaged.
const LEAST_TEXELS: f32 = 0.5;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    photograph = given;
    let place = places[id.x];
    let seen = projected(place.xyz);
    let texels = place.w * photograph.lens.focal.y / seen.position.z;
    let width = clamp(texels, 1.0, photograph.max_texels);
    let short_side = min(photograph.lens.size.x, photograph.lens.size.y);
    let texel = vec2<i32>(photograph.map_focal * seen.normalised + photograph.map_centre);
    // The border is 0 where nothing is seen.
    let sees = place.w > 0.0
        && texels >= LEAST_TEXELS
        && seen.border * short_side >= width
        && agrees(seen.position.z, known_at(texel));
    var found = vec2(0u);
    if sees {
        let colour = look_up(seen.pixel, width);
        if colour.a > 0.0 {
            found = vec2(pack2x16unorm(colour.rg), pack2x16unorm(vec2(colour.b, 1.0)));
        }
    }
    samples[id.x] = found;
}

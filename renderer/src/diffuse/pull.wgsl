// A level of the pyramid from the next finer one: four values, summed by their weights, which
// count as one at most. FORMAT stands for that of the levels.

@group(0) @binding(0) var finer: texture_2d_array<f32>;
@group(0) @binding(1) var coarser: texture_storage_2d_array<FORMAT, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let limit = textureDimensions(finer);
    var sum = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let texel = 2u * id.xy + vec2(i & 1u, i >> 1u);
        let value = textureLoad(finer, min(texel, limit - 1u), id.z, 0);
        sum += select(vec4(0.0), value, all(texel < limit));
    }
    // What lies beyond the border is not stored.
    textureStore(coarser, id.xy, id.z, sum / max(sum.w, 1.0));
}

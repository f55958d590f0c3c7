// Fills what a level of the pyramid lacks from the next coarser one, as that was diffused. FORMAT stands
// for that of the levels.

@group(0) @binding(0) var level: texture_2d_array<f32>;
@group(0) @binding(1) var coarser: texture_2d_array<f32>;
@group(0) @binding(2) var diffused: texture_storage_2d_array<FORMAT, write>;
// The layer from which on nothing is filled on this level.
@group(0) @binding(3) var<uniform> first_left: u32;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let inside = min(id.xy, textureDimensions(level) - 1u);
    let known = textureLoad(level, inside, id.z, 0);
    let limit = vec2<i32>(textureDimensions(coarser)) - 1;
    let between = 0.5 * (vec2<f32>(id.xy) + 0.5) - 0.5;
    let first = floor(between);
    let t = between - first;
    var filled = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(vec2(i & 1u, i >> 1u));
        let texel = clamp(vec2<i32>(first + step), vec2(0), limit);
        let weight = mix(1.0 - t, t, step);
        filled += weight.x * weight.y * textureLoad(coarser, texel, id.z, 0);
    }
    let lacking = select(0.0, 1.0 - known.w, id.z < first_left);
    // What lies beyond the border is not stored.
    textureStore(diffused, id.xy, id.z, known + lacking * filled);
}

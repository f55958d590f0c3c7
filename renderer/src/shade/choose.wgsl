// Which camera of a rig sees each pixel's place best: as a depth, so that the device's depth
// test keeps the largest, and its stencil which camera that was. Needs photograph.wgsl and
// blend.wgsl.

@fragment
fn fs(corner: Corner) -> @builtin(frag_depth) f32 {
    take(corner);
    let at = corner.position;
    let place = textureLoad(positions, vec2<i32>(at.xy), 0);
    let border = projected(bitcast<vec3<f32>>(place.xyz)).border;
    let depth = photograph.rig_floor + photograph.rig_step * rig_score(border, photograph.closeness);
    return select(0.0, depth, place.w != 0u && border > 0.0);
}

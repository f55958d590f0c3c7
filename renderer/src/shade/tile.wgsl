// Photographs over the tiles of a picture that they can see something of. Needs photograph.wgsl.
//
// Fragments take the photograph and the eye from the corners of the tile rather than from uniforms:
// Mesa's software driver reads every word of a uniform once for each pixel. They do without the
// model of the lens, which is a constant, and the size of the depth map.

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) w0: vec4<u32>,
    @location(1) @interpolate(flat) w1: vec4<u32>,
    @location(2) @interpolate(flat) w2: vec4<u32>,
    @location(3) @interpolate(flat) w3: vec4<u32>,
    @location(4) @interpolate(flat) w4: vec4<u32>,
    @location(5) @interpolate(flat) w5: vec4<u32>,
    @location(6) @interpolate(flat) w6: vec4<u32>,
    @location(7) @interpolate(flat) w7: vec4<u32>,
    @location(8) @interpolate(flat) w8: vec4<u32>,
    @location(9) @interpolate(flat) w9: vec4<u32>,
    @location(10) @interpolate(flat) w10: vec4<u32>,
    @location(11) @interpolate(flat) w11: vec4<u32>,
    @location(12) @interpolate(flat) w12: vec4<u32>,
    @location(13) @interpolate(flat) w13: vec4<u32>,
    @location(14) @interpolate(flat) w14: vec4<u32>,
}

// Pixels a side of a tile, see tiles/mod.rs.
const TILE: u32 = 32u;

const TESTS_DEPTH: u32 = 1u;
const SHOWS_MARKS: u32 = 2u;

// A corner of a square of tiles, as tiles.wgsl lists them, of a picture of `size` pixels; four make a strip.
fn corner_of(tile: u32, index: u32, size: vec2<f32>) -> Corner {
    let first = vec2(tile & 0x3fffu, tile >> 16u);
    let cell = first + (vec2(index & 1u, index >> 1u) << vec2((tile >> 14u) & 3u));
    let ndc = 2.0 * vec2<f32>(cell * TILE) / size - 1.0;
    let p = given;
    let e = eye_of_frame();
    let flags = select(0u, TESTS_DEPTH, e.tests_depth) | select(0u, SHOWS_MARKS, e.shows_marks);
    var corner: Corner;
    // As deep as its rig, where it does not compare itself with others of that.
    corner.position = vec4(ndc.x, -ndc.y, p.rig_floor + 0.5 * p.rig_step, 1.0);
    corner.w0 = vec4(bitcast<vec2<u32>>(p.lens.focal), bitcast<vec2<u32>>(p.lens.centre));
    corner.w1 = vec4(bitcast<vec2<u32>>(p.lens.distortion_centre), bitcast<u32>(p.lens.limit), flags);
    corner.w2 = bitcast<vec4<u32>>(p.lens.k);
    corner.w3 = vec4(bitcast<vec2<u32>>(p.lens.tangential), bitcast<vec2<u32>>(p.lens.size));
    corner.w4 = vec4(bitcast<vec3<u32>>(p.right), p.layer);
    corner.w5 = vec4(bitcast<vec3<u32>>(p.down), p.map_layer);
    corner.w6 = vec4(bitcast<vec3<u32>>(p.forward), bitcast<u32>(p.eye_distance_2));
    corner.w7 = vec4(bitcast<vec3<u32>>(p.centre), bitcast<u32>(p.pose_m));
    corner.w8 = vec4(bitcast<vec2<u32>>(p.map_focal), bitcast<vec2<u32>>(p.map_centre));
    corner.w9 = vec4(bitcast<u32>(e.texels_per_pixel), bitcast<u32>(p.map_texel), bitcast<vec2<u32>>(p.corner));
    corner.w10 = vec4(bitcast<vec3<u32>>(p.gain), bitcast<u32>(p.max_texels));
    corner.w11 = vec4(bitcast<vec3<u32>>(p.mark), bitcast<u32>(p.rig_weight));
    corner.w12 = vec4(bitcast<u32>(p.closeness), bitcast<u32>(p.rig_floor), bitcast<u32>(p.rig_step), bitcast<u32>(p.shift));
    corner.w13 = vec4(bitcast<vec2<u32>>(p.texel), bitcast<u32>(p.shift_step), 0u);
    corner.w14 = bitcast<vec4<u32>>(e.axis);
    return corner;
}

fn take(corner: Corner) {
    photograph.lens.focal = bitcast<vec2<f32>>(corner.w0.xy);
    photograph.lens.centre = bitcast<vec2<f32>>(corner.w0.zw);
    photograph.lens.distortion_centre = bitcast<vec2<f32>>(corner.w1.xy);
    photograph.lens.limit = bitcast<f32>(corner.w1.z);
    eye.tests_depth = (corner.w1.w & TESTS_DEPTH) != 0u;
    eye.shows_marks = (corner.w1.w & SHOWS_MARKS) != 0u;
    photograph.lens.k = bitcast<vec4<f32>>(corner.w2);
    photograph.lens.tangential = bitcast<vec2<f32>>(corner.w3.xy);
    photograph.lens.size = bitcast<vec2<f32>>(corner.w3.zw);
    photograph.right = bitcast<vec3<f32>>(corner.w4.xyz);
    photograph.layer = corner.w4.w;
    photograph.down = bitcast<vec3<f32>>(corner.w5.xyz);
    photograph.map_layer = corner.w5.w;
    photograph.forward = bitcast<vec3<f32>>(corner.w6.xyz);
    photograph.eye_distance_2 = bitcast<f32>(corner.w6.w);
    photograph.centre = bitcast<vec3<f32>>(corner.w7.xyz);
    photograph.pose_m = bitcast<f32>(corner.w7.w);
    photograph.map_focal = bitcast<vec2<f32>>(corner.w8.xy);
    photograph.map_centre = bitcast<vec2<f32>>(corner.w8.zw);
    eye.texels_per_pixel = bitcast<f32>(corner.w9.x);
    photograph.map_texel = bitcast<f32>(corner.w9.y);
    photograph.corner = bitcast<vec2<f32>>(corner.w9.zw);
    photograph.gain = bitcast<vec3<f32>>(corner.w10.xyz);
    photograph.max_texels = bitcast<f32>(corner.w10.w);
    photograph.mark = bitcast<vec3<f32>>(corner.w11.xyz);
    photograph.rig_weight = bitcast<f32>(corner.w11.w);
    photograph.closeness = bitcast<f32>(corner.w12.x);
    photograph.rig_floor = bitcast<f32>(corner.w12.y);
    photograph.rig_step = bitcast<f32>(corner.w12.z);
    photograph.shift = bitcast<f32>(corner.w12.w);
    photograph.texel = bitcast<vec2<f32>>(corner.w13.xy);
    photograph.shift_step = bitcast<f32>(corner.w13.z);
    eye.axis = bitcast<vec4<f32>>(corner.w14);
}

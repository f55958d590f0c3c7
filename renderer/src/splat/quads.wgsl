// Large discs as quads of four vertices, one instance each: what splat.wgsl does in a loop, a
// fragment does for its pixel. Needs camera.wgsl, plane.wgsl, disc.wgsl, large.wgsl, job.wgsl and
// one of nearest_32.wgsl and nearest_64.wgsl.

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(7) var<storage, read> large: array<Large>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    // As in `Large`.
    @location(0) @interpolate(flat) middle_slope: vec4<f32>,
    @location(1) @interpolate(flat) lift_depth_behind: vec4<f32>,
    @location(2) @interpolate(flat) conic_index: vec4<u32>,
}

@vertex
fn vs(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    let entry = large[instance];
    let side = vec2(vertex & 1u, vertex >> 1u) == vec2(1u);
    let at = select(entry.low_high.xy, entry.low_high.zw + 1.0, side) / vec2<f32>(job.camera.size);
    var corner: Corner;
    corner.position = vec4(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0);
    corner.middle_slope = entry.middle_slope;
    corner.lift_depth_behind = entry.lift_depth_behind;
    corner.conic_index = entry.conic_index;
    return corner;
}

@fragment
fn fs(corner: Corner) {
    phase = job.phase;
    var disc: Disc;
    disc.middle = corner.middle_slope.xy;
    disc.slope = corner.middle_slope.zw;
    disc.lift = corner.lift_depth_behind.xy;
    disc.depth = corner.lift_depth_behind.z;
    disc.conic = bitcast<vec3<f32>>(corner.conic_index.xyz);
    let at = floor(corner.position.xy);
    let depth = depth_at(disc, at);
    let texel = u32(at.y) * job.stride + u32(at.x);
    offer(texel, depth > 0.0, depth + corner.lift_depth_behind.w, corner.conic_index.w);
}

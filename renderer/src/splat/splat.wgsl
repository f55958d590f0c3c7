// Points as discs. One thread a point. Needs camera.wgsl, plane.wgsl, disc.wgsl, large.wgsl,
// postpone.wgsl, job.wgsl, drawn.wgsl, one of nearest_32.wgsl and nearest_64.wgsl, and one of eye.wgsl and
// estimated.wgsl.

const BLOCK_POINTS: u32 = 256u;
// Mirror those in splat/run.rs.
const STRIPS: u32 = 16u;
const RUN: u32 = 32u;

// In storage: of that software devices read what all threads want once, while none has returned; of
// uniforms they read every word for each thread.
@group(0) @binding(0) var<storage, read> job: Job;
// Position relative to the chunk's origin as three f32; then the code: colour in the low 24
// bits, radius in bits 24 to 30 (0: no point), bit 31 set where there is a colour.
@group(0) @binding(1) var<storage, read> points: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> blocks: array<Drawn>;

// All phases run this one entry point, so that they compute the same bits.
@compute @workgroup_size(256)
fn splat(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let job = job;
    phase = job.phase;
    let camera = job.camera;
    let entry = job.first_block + turn_of(group.xy);
    let drawn = blocks[min(entry, job.end_block - 1u)];
    let placement = drawn.placement;
    let behind_m = bitcast<f32>(drawn.block_behind.y);
    if entry >= job.end_block {
        return;
    }
    let place = drawn.block_behind.x * BLOCK_POINTS + lane;
    let point = points[place];
    let code = (point.w >> 24u) & 0x7fu;
    if code == 0u {
        return;
    }
    let p = cam_from_world(camera, placement.xyz + bitcast<vec3<f32>>(point.xyz));
    if !(p.z >= camera.near) {
        return;
    }
    let stored = select(radius_from_code(code), placement.w, placement.w > 0.0);
    let n = normal_of(place);
    let radius = drawn_radius(job, p, stored);
    let disc = disc_around(camera, p, cam_from_world(camera, n), radius);
    let extent = extent_of(disc, camera.size);
    // Written so that NaN is refused.
    if !(extent.low.x <= extent.high.x && extent.low.y <= extent.high.y) {
        return;
    }
    let columns = extent.high.x - extent.low.x + 1.0;
    let pixels = u32(columns * (extent.high.y - extent.low.y + 1.0));
    let index = entry * BLOCK_POINTS + lane;
    if pixels > job.most_pixels && postponed(disc, extent, index, behind_m) {
        return;
    }
    let push = select(job.push_on_plane, job.push, all(n == vec3(0.0))) * radius + behind_m;
    // One loop: two would wait for the widest disc of a group of threads in every row.
    var at = extent.low;
    var texel = u32(at.y) * job.stride + u32(at.x);
    let to_next_row = job.stride + 1u - u32(columns);
    for (var i = 0u; i < pixels; i++) {
        let depth = depth_at(disc, at);
        offer(texel, depth > 0.0, depth + push, index);
        let ends = at.x == extent.high.x;
        texel += select(1u, to_next_row, ends);
        at = select(vec2(at.x + 1.0, at.y), vec2(extent.low.x, at.y + 1.0), ends);
    }
}

// Neighbouring blocks have discs of like sizes, and a software device gives each of its threads
// as many workgroups on end: strips, which each take every sixteenth run of blocks, are equally much
// work. Runs, because threads that draw neighbours at once wait for each other's pixels.
// group: place in its strip, and strip.
fn turn_of(group: vec2<u32>) -> u32 {
    return (group.x / RUN * STRIPS + group.y) * RUN + group.x % RUN;
}

fn drawn_radius(job: Job, p: vec3<f32>, stored: f32) -> f32 {
    let focal = min(job.camera.focal.x, job.camera.focal.y);
    // Of the point, too, so that it is no branch on a uniform: see shade/colour.wgsl.
    if (job.camera.orthographic == 1u) & (p.z > 0.0) {
        return clamp(stored, job.min_radius_px / focal, job.max_radius_px / focal);
    }
    // Half its depth at most, so that no disc reaches the plane of the eye.
    let largest = min(job.max_radius_px / focal * p.z * p.z / length(p), 0.5 * p.z);
    return min(max(stored, job.min_radius_px / focal * p.z), largest);
}

// Metres. Eight steps an octave from 1 mm.
fn radius_from_code(code: u32) -> f32 {
    return 0.001 * exp2(f32(code) * 0.125);
}

// Points as discs. One thread a point. Needs camera.wgsl, plane.wgsl, disc.wgsl, one of
// nearest_32.wgsl and nearest_64.wgsl, and one of eye.wgsl and estimated.wgsl.

// Mirrors `gpu_data::Job` in splat/mod.rs.
struct Job {
    camera: Camera,
    // 0: nearest depth. 1: lowest index among those at that depth.
    phase: u32,
    // First of this job's blocks in `blocks`.
    first_block: u32,
    // Texels a row of the target.
    stride: u32,
    // Smallest radius, pixels: one that surely covers a pixel centre.
    min_radius_px: f32,
    max_radius_px: f32,
    // Depths are pushed back by this share of the radius: of discs that face the eye, and of
    // those on the plane of a normal.
    push: f32,
    push_on_plane: f32,
    padding: u32,
}

const BLOCK_POINTS: u32 = 256u;

@group(0) @binding(0) var<uniform> job: Job;
// Position relative to the chunk's origin as three f32; then the code: colour in the low 24
// bits, radius in bits 24 to 30 (0: no point), bit 31 set where there is a colour.
@group(0) @binding(1) var<storage, read> points: array<vec4<u32>>;
// Block number in this page, and its chunk's place in `placements`.
@group(0) @binding(2) var<storage, read> blocks: array<vec2<u32>>;
// Chunk origin minus the camera's centre, taken in f64; then the radius of all its points in
// metres, 0 where each has its own.
@group(0) @binding(3) var<storage, read> placements: array<vec4<f32>>;

// All phases run this one entry point, so that they compute the same bits.
@compute @workgroup_size(256)
fn splat(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let entry = job.first_block + group.x;
    let block = blocks[entry];
    let place = block.x * BLOCK_POINTS + lane;
    let point = points[place];
    let code = (point.w >> 24u) & 0x7fu;
    if code == 0u {
        return;
    }
    let placement = placements[block.y];
    let camera = job.camera;
    let p = cam_from_world(camera, placement.xyz + bitcast<vec3<f32>>(point.xyz));
    if !(p.z >= camera.near) {
        return;
    }
    let stored = select(radius_from_code(code), placement.w, placement.w > 0.0);
    let n = normal_of(place);
    let radius = drawn_radius(p, stored);
    let disc = disc_around(camera, p, cam_from_world(camera, n), radius);
    let extent = extent_of(disc, camera.size);
    // Written so that NaN is refused.
    if !(extent.low.x <= extent.high.x && extent.low.y <= extent.high.y) {
        return;
    }
    let push = select(job.push_on_plane, job.push, all(n == vec3(0.0))) * radius;
    let index = entry * BLOCK_POINTS + lane;
    for (var y = extent.low.y; y <= extent.high.y; y += 1.0) {
        for (var x = extent.low.x; x <= extent.high.x; x += 1.0) {
            let depth = depth_at(disc, vec2(x, y));
            if depth > 0.0 {
                offer(u32(y) * job.stride + u32(x), depth + push, index);
            }
        }
    }
}

fn drawn_radius(p: vec3<f32>, stored: f32) -> f32 {
    let focal = min(job.camera.focal.x, job.camera.focal.y);
    if job.camera.orthographic == 1u {
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

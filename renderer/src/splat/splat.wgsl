// Points as discs that face the camera. One thread a point. Needs camera.wgsl.
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
    // Depths are pushed back by this share of the radius.
    push: f32,
    padding: vec2<u32>,
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
@group(0) @binding(4) var<storage, read_write> depths: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> indices: array<atomic<u32>>;

// Both phases run this one entry point, so that they compute the same bits.
@compute @workgroup_size(256)
fn splat(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let entry = job.first_block + group.x;
    let block = blocks[entry];
    let point = points[block.x * BLOCK_POINTS + lane];
    let code = (point.w >> 24u) & 0x7fu;
    if code == 0u {
        return;
    }
    let camera = job.camera;
    let placement = placements[block.y];
    let p = cam_from_world(camera, placement.xyz + bitcast<vec3<f32>>(point.xyz));
    if !(p.z >= camera.near) {
        return;
    }
    let m = p.xy / p.z;
    let off_axis = sqrt(1.0 + dot(m, m));
    let pixel_m = p.z / min(camera.focal.x, camera.focal.y);
    let radius = min(
        max(select(radius_from_code(code), placement.w, placement.w > 0.0), job.min_radius_px * pixel_m),
        job.max_radius_px * pixel_m / off_axis,
    );
    // Half the box around the disc's picture: first order in the plane, divided by the depth
    // of the disc's nearest edge.
    let nearest = max(p.z - radius * length(m) / off_axis, 0.5 * p.z);
    let half_box = camera.focal * radius * sqrt(1.0 + m * m) / nearest;
    let middle = camera.focal * m + camera.centre;
    let limit = vec2<f32>(camera.size) - 1.0;
    // Compared as floats first: positions far outside do not fit an integer.
    let low = max(ceil(middle - half_box - 0.5), vec2(0.0));
    let high = min(floor(middle + half_box - 0.5), limit);
    if !(low.x <= high.x && low.y <= high.y) {
        return;
    }
    let index = entry * BLOCK_POINTS + lane;
    let squared = dot(p, p);
    // The radius is at most max_radius_px pixels, so these loops are short.
    for (var y = i32(low.y); y <= i32(high.y); y++) {
        for (var x = i32(low.x); x <= i32(high.x); x++) {
            let ray = ray_from_pixel(camera, vec2(f32(x), f32(y)) + 0.5);
            let facing = dot(p, ray);
            if facing <= 0.0 {
                continue;
            }
            let z = squared / facing;
            let off = ray * z - p;
            if dot(off, off) > radius * radius {
                continue;
            }
            // Positive floats order as their bits do.
            let bits = bitcast<u32>(z + job.push * radius);
            let texel = u32(y) * job.stride + u32(x);
            if job.phase == 0u {
                if bits < atomicLoad(&depths[texel]) {
                    atomicMin(&depths[texel], bits);
                }
            } else if bits == atomicLoad(&depths[texel]) {
                atomicMin(&indices[texel], index);
            }
        }
    }
}

// Metres. Eight steps an octave from 1 mm.
fn radius_from_code(code: u32) -> f32 {
    return 0.001 * exp2(f32(code) * 0.125);
}

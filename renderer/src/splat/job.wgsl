// What a run over the points is to do. Needs camera.wgsl.

// Mirrors `gpu_data::Job` in splat/mod.rs.
struct Job {
    camera: Camera,
    // 0: nearest depth. 1: lowest index among those at that depth.
    phase: u32,
    // This job's share of `blocks`.
    first_block: u32,
    end_block: u32,
    // Texels a row of the target.
    stride: u32,
    // Smallest radius, pixels: one that surely covers a pixel centre.
    min_radius_px: f32,
    max_radius_px: f32,
    // Depths are pushed back by this share of the radius: of discs that face the eye, and of
    // those on the plane of a normal.
    push: f32,
    push_on_plane: f32,
    // Discs whose box has more pixels are left to quads.
    most_pixels: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

// Of the job, as the entry point has read it.
var<private> phase: u32;

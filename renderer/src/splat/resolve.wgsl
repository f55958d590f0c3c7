// Which point each pixel shows: its position and code, from the index that won. One pass a
// page of points, each over what the others left. Needs drawn.wgsl, screen.wgsl, and
// winner_eye.wgsl or winner_estimated.wgsl.

// Mirrors `gpu_data::Page` in splat/resolve.rs.
struct Page {
    // Pixels a row.
    width: u32,
    // Words between one pixel's index and the next one's.
    stride: u32,
    // This page's share of `blocks`.
    first_block: u32,
    end_block: u32,
}

@group(0) @binding(0) var<uniform> page: Page;
@group(0) @binding(1) var<storage, read> points: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> blocks: array<Drawn>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Winner {
    let pixel = vec2<u32>(at.xy);
    let index = indices[(pixel.y * page.width + pixel.x) * page.stride];
    let entry = index / 256u;
    let is_other = entry < page.first_block || entry >= page.end_block;
    // The first page empties what it has no winner for, which a later one may fill.
    if is_other & (page.first_block > 0u) {
        discard;
    }
    let drawn = blocks[min(entry, page.end_block - 1u)];
    let place = drawn.block_behind.x * 256u + index % 256u;
    let point = points[place];
    let position = drawn.placement.xyz + bitcast<vec3<f32>>(point.xyz);
    let shown = winner(vec4(bitcast<vec3<u32>>(position), point.w), place);
    if is_other {
        return Winner();
    }
    return shown;
}

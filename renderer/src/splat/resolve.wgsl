// Which point each pixel shows: its position and code, from the index that won. One pass a
// page of points. Mirrors `gpu_data::Resolve` in splat/mod.rs.

struct Resolve {
    size: vec2<u32>,
    // This page's share of `blocks`.
    first_block: u32,
    end_block: u32,
}

@group(0) @binding(0) var<uniform> resolve: Resolve;
@group(0) @binding(1) var<storage, read> points: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> blocks: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> placements: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> indices: array<u32>;
@group(0) @binding(5) var winners: texture_storage_2d<rgba32uint, write>;

@compute @workgroup_size(16, 16)
fn resolve_page(@builtin(global_invocation_id) pixel: vec3<u32>) {
    if any(pixel.xy >= resolve.size) {
        return;
    }
    let index = indices[pixel.y * resolve.size.x + pixel.x];
    let entry = index / 256u;
    if entry < resolve.first_block || entry >= resolve.end_block {
        return;
    }
    let block = blocks[entry];
    let point = points[block.x * 256u + index % 256u];
    let position = placements[block.y].xyz + bitcast<vec3<f32>>(point.xyz);
    textureStore(winners, pixel.xy, vec4(bitcast<vec3<u32>>(position), point.w));
}

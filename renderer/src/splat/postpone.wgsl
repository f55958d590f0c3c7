// Puts large discs on a list. Needs large.wgsl.

// Arguments of an indirect draw: vertices, instances, first vertex, first instance.
@group(0) @binding(6) var<storage, read_write> draw: array<atomic<u32>, 4>;
@group(0) @binding(7) var<storage, read_write> large: array<Large>;

// Whether there was room.
fn postponed(disc: Disc, extent: Extent, index: u32, behind_m: f32) -> bool {
    let capacity = arrayLength(&large);
    let slot = atomicAdd(&draw[1], 1u);
    if slot >= capacity {
        // However many came too late, their last word is this.
        atomicMin(&draw[1], capacity);
        return false;
    }
    large[slot] = Large(
        vec4(disc.middle, disc.slope),
        vec4(disc.lift, disc.depth, behind_m),
        vec4(extent.low, extent.high),
        vec4(bitcast<vec3<u32>>(disc.conic), index),
    );
    return true;
}

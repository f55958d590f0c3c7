// What a pixel keeps, for devices without atomics of 64 bits: the nearest depth in a first
// phase, and in a second the lowest index of those at that depth.

@group(0) @binding(4) var<storage, read_write> depths: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> indices: array<atomic<u32>>;

// Positive floats order as their bits do.
fn offer(texel: u32, depth: f32, index: u32) {
    let bits = bitcast<u32>(depth);
    // Of the depth, too, which is positive, so that it is no branch on a uniform: see
    // shade/colour.wgsl.
    if (phase == 0u) & (depth > 0.0) {
        if bits < atomicLoad(&depths[texel]) {
            atomicMin(&depths[texel], bits);
        }
    } else if bits == atomicLoad(&depths[texel]) {
        atomicMin(&indices[texel], index);
    }
}

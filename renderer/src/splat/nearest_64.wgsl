// What a pixel keeps, in one word of 64 bits: depth above index, so that the smallest is the
// nearest, and among those at its depth the one of lowest index.

@group(0) @binding(4) var<storage, read_write> nearest: array<atomic<u64>>;

// Positive floats order as their bits do.
fn offer(texel: u32, depth: f32, index: u32) {
    let key = (u64(bitcast<u32>(depth)) << 32u) | u64(index);
    if key < atomicLoad(&nearest[texel]) {
        atomicMin(&nearest[texel], key);
    }
}

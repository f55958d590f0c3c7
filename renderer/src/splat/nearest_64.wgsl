// What a pixel keeps, in one word of 64 bits: depth above index, so that the smallest is the
// nearest, and among those at its depth the one of lowest index.

@group(0) @binding(3) var<storage, read_write> nearest: array<atomic<u64>>;

// `within`: whether the disc covers the pixel. All look at what it keeps, those that are within and
// those that are not: software devices look for one thread after the other, and whether one is within
// they cannot foresee. Positive floats order as their bits do.
fn offer(texel: u32, within: bool, depth: f32, index: u32) {
    let kept = atomicLoad(&nearest[texel]);
    let key = (u64(bitcast<u32>(depth)) << 32u) | u64(index);
    if within & (key < kept) {
        atomicMin(&nearest[texel], key);
    }
}

// What a pixel keeps, for devices without atomics of 64 bits: the nearest depth in a first
// phase, and in a second the lowest index of those at that depth.

@group(0) @binding(3) var<storage, read_write> depths: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> indices: array<atomic<u32>>;

// As in nearest_64.wgsl.
fn offer(texel: u32, within: bool, depth: f32, index: u32) {
    let kept = atomicLoad(&depths[texel]);
    let bits = bitcast<u32>(depth);
    if within & (phase == 0u) & (bits < kept) {
        atomicMin(&depths[texel], bits);
    }
    if within & (phase == 1u) & (bits == kept) {
        atomicMin(&indices[texel], index);
    }
}

// One instance a square of tiles. Needs tile.wgsl.

@vertex
fn vs(@builtin(vertex_index) index: u32, @location(0) tile: u32) -> Corner {
    return corner_of(tile, index, frame.size);
}

// Vertices of tiles. Needs tile.wgsl.

@vertex
fn vs(@builtin(vertex_index) vertex: u32, @location(0) tile: u32) -> Corner {
    return corner_of(tile, vertex, frame.size);
}

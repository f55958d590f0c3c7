// A block that is drawn.

// Mirrors `Drawn` in points/draw_list.rs.
struct Drawn {
    // Its number in this page.
    block: u32,
    // Its chunk's place in `placements`.
    placement: u32,
    // Depths are pushed back by this, metres, where points are compared.
    behind_m: f32,
}

// A block that is drawn.

// Mirrors `Drawn` in points/draw_list.rs. Two vectors: software devices read each of them in a turn
// of its own.
struct Drawn {
    // Its chunk's origin minus the camera's centre, taken in f64; then the radius of all its
    // points in metres, 0 where each has its own.
    placement: vec4<f32>,
    // Its number in this page, and the bits of the metres by which depths are pushed back where
    // points are compared.
    block_behind: vec2<u32>,
    padding: vec2<u32>,
}

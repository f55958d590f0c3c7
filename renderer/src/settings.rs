//! What a renderer may be told to do differently.

/// Choices that trade quality, speed and memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How many rigs (panoramas), nearest to the eye, may colour a pixel.
    pub rigs: usize,
    /// Longest side of a photograph's depth map, texels, 16 to 2048.
    pub depth_map_side: u32,
    /// Radius of a splat as a share of the distance between points. A square grid closes
    /// up from 0.71.
    pub splat_scale: f32,
    /// Largest radius of a splat, metres: coarse levels stay points rather than become walls.
    pub max_splat_radius_m: f32,
    /// Bytes of texture for photographs.
    pub image_memory_bytes: u64,
    /// Bytes of buffers for points.
    pub point_memory_bytes: u64,
    /// Colour where there is no geometry, sRGB.
    pub background: [u8; 3],
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            rigs: 8,
            depth_map_side: 512,
            splat_scale: 0.75,
            max_splat_radius_m: 0.25,
            image_memory_bytes: 3 << 30,
            point_memory_bytes: 1 << 30,
            background: [178, 190, 202],
        }
    }
}

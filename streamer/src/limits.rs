//! How much of a scene a view may ask for.

/// Limits of what is fetched and held for one view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FetchLimits {
    /// Buildings and terrain within this distance of the eye, metres.
    pub mesh_radius_m: f64,
    /// Photographs of this many panoramas: the nearest that see what the view sees.
    pub panoramas: usize,
    /// Panoramas within this distance of the eye, metres.
    pub panorama_radius_m: f64,
    /// Pixels of all photographs together, four bytes each once decoded.
    pub image_pixels: u64,
    /// Longest side of a photograph, pixels: where it has more its levels are taken from the first that
    /// has not, if there is one.
    pub image_side: u32,
    /// Points of all nodes together.
    pub points: u64,
    /// Bytes of all nodes together, as they are fetched.
    pub point_bytes: u64,
    /// Point nodes within this distance of the eye, metres.
    pub point_radius_m: f64,
    /// Nodes are refined until their points appear this close in the view, pixels.
    pub point_spacing_px: f64,
}

impl Default for FetchLimits {
    /// What a machine without a graphics card renders in about a second.
    fn default() -> Self {
        Self {
            mesh_radius_m: 400.0,
            panoramas: 12,
            panorama_radius_m: 200.0,
            image_pixels: 96 << 20,
            // What flaneur's renderer takes where the device has textures of twelve thousand pixels.
            image_side: 8192,
            points: 4_000_000,
            point_bytes: u64::MAX,
            point_radius_m: 200.0,
            point_spacing_px: 1.0,
        }
    }
}

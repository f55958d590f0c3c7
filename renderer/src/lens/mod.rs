//! Lenses on the device: directions to raw pixels, and raw pixels back to directions.
//!
//! The forward model is evaluated per lookup, in f32, with its limit. The inverse is needed
//! only for the pixels of a distorted view: it is solved in f64 on a coarse grid of pixels,
//! interpolated, and corrected on the device by steps of Broyden's method.

use flaneur_scene::Distortion;
use glam::UVec2;

#[cfg(test)]
mod tests;

/// The forward model, to be put before the shaders that use it.
pub(crate) const WGSL: &str = include_str!("lens.wgsl");

/// How many models there are.
pub(crate) const MODELS: usize = 4;

/// Pixels between the nodes of the grid of [`undistortion_grid`].
pub(crate) const GRID_STEP: u32 = 8;

/// Marks a node that no direction reaches.
pub(crate) const NOWHERE: f32 = 1e30;

pub(crate) mod gpu_data {
    /// Mirrors `Lens` in lens.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Lens {
        pub(crate) focal: [f32; 2],
        pub(crate) centre: [f32; 2],
        pub(crate) distortion_centre: [f32; 2],
        pub(crate) limit: f32,
        pub(crate) model: u32,
        pub(crate) k: [f32; 4],
        pub(crate) tangential: [f32; 2],
        pub(crate) size: [f32; 2],
    }
}

impl gpu_data::Lens {
    pub(crate) fn new(lens: &flaneur_scene::Lens) -> Self {
        let i = lens.intrinsics;
        // Squared on the device, so kept where the square is finite.
        let limit = lens.distortion.limit().min(1e18) as f32;
        let mut data = Self {
            focal: [i.fx as f32, i.fy as f32],
            centre: [i.cx as f32, i.cy as f32],
            limit,
            size: lens.size.as_vec2().to_array(),
            ..Self::default()
        };
        match lens.distortion {
            Distortion::None => {}
            Distortion::RadialPixels { centre, k, .. } => {
                data.model = 1;
                data.distortion_centre = centre.as_vec2().to_array();
                data.k = [k[0] as f32, k[1] as f32, k[2] as f32, 0.0];
            }
            Distortion::Brown { k, p } => {
                data.model = 2;
                data.k = [k[0] as f32, k[1] as f32, k[2] as f32, 0.0];
                data.tangential = p.map(|x| x as f32);
            }
            Distortion::Fisheye { k } => {
                data.model = 3;
                data.k = k.map(|x| x as f32);
            }
        }
        data
    }
}

/// Nodes of the grid over a picture of `size`: one every [`GRID_STEP`] pixels, to beyond
/// its far borders.
pub(crate) fn grid_size(size: UVec2) -> UVec2 {
    size.map(|side| side.div_ceil(GRID_STEP) + 1)
}

/// The normalised direction (x/z, y/z) of every [`GRID_STEP`]th raw pixel corner, rows from
/// the top, [`NOWHERE`] where there is none.
pub(crate) fn undistortion_grid(lens: &flaneur_scene::Lens) -> Vec<[f32; 2]> {
    let size = grid_size(lens.size);
    let step = f64::from(GRID_STEP);
    (0..size.y)
        .flat_map(|y| (0..size.x).map(move |x| glam::DVec2::new(f64::from(x), f64::from(y))))
        .map(|node| {
            lens.unproject(node * step)
                .map(|d| d.truncate().as_vec2())
                .filter(|m| m.is_finite())
                .map_or([NOWHERE; 2], |m| m.to_array())
        })
        .collect()
}

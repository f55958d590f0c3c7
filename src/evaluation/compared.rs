//! Pictures that are compared.

use flaneur_renderer::{Frame, Surface};
use flaneur_scene::ImageUpdate;
use glam::UVec2;

/// A photograph, or a rendering of what it shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Compared {
    /// Size in pixels.
    pub(crate) size: UVec2,
    /// sRGB, rows from the top, three bytes a pixel.
    pub(crate) rgb: Vec<u8>,
    /// For each pixel of a photograph, whether its mask lets the scene be seen; of a rendering,
    /// whether a photograph colours it, be it at an inferred depth.
    pub(crate) counts: Vec<bool>,
    /// Share of the pixels showing geometry that at least one photograph colours; `None` where no
    /// pixel shows geometry, as in a photograph.
    pub(crate) coverage: Option<f64>,
    /// Share of all pixels that photographs colour at an inferred depth.
    pub(crate) inferred: f64,
}

impl Compared {
    /// The picture of straight alpha: what has any counts.
    fn from_rgba(size: UVec2, rgba: &[u8]) -> Self {
        let counts = rgba.chunks_exact(4).map(|pixel| pixel[3] > 0).collect();
        Self { size, rgb: rgb(rgba), counts, coverage: None, inferred: 0.0 }
    }

    /// A picture all of which counts.
    pub(crate) fn whole(picture: image::RgbImage) -> Self {
        let size = UVec2::new(picture.width(), picture.height());
        let rgb = picture.into_raw();
        Self { size, counts: vec![true; rgb.len() / 3], rgb, coverage: None, inferred: 0.0 }
    }

    /// The same picture stretched to `size`: a pixel is the mean of what it covers where that is
    /// more than a pixel, else interpolated.
    pub(crate) fn resized(self, size: UVec2) -> Self {
        if self.size == size {
            return self;
        }
        let rgba = self
            .rgb
            .chunks_exact(3)
            .zip(&self.counts)
            .flat_map(|(rgb, &counts)| [rgb[0], rgb[1], rgb[2], if counts { 255 } else { 0 }])
            .collect();
        let Some(picture) = image::RgbaImage::from_raw(self.size.x, self.size.y, rgba) else {
            return self;
        };
        let filter = image::imageops::FilterType::Triangle;
        let resized = image::imageops::resize(&picture, size.x, size.y, filter);
        Self::from_rgba(size, resized.as_raw())
    }
}

impl From<&ImageUpdate> for Compared {
    fn from(photograph: &ImageUpdate) -> Self {
        Self::from_rgba(photograph.size, &photograph.rgba)
    }
}

impl From<&Frame> for Compared {
    fn from(frame: &Frame) -> Self {
        Self {
            size: frame.size,
            rgb: rgb(&frame.rgba),
            counts: frame.surfaces.iter().copied().map(is_covered).collect(),
            coverage: (frame.stats.geometry_pixels > 0).then(|| frame.stats.coverage()),
            inferred: frame.stats.inferred_share(),
        }
    }
}

/// Whether a photograph colours the pixel, be it at an inferred depth.
pub(super) fn is_covered(surface: Surface) -> bool {
    surface.is_coloured() || surface == Surface::Inferred
}

/// Share of those that are true.
pub(super) fn share(counts: &[bool]) -> f64 {
    counts.iter().filter(|counts| **counts).count() as f64 / counts.len() as f64
}

fn rgb(rgba: &[u8]) -> Vec<u8> {
    rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_renderer::FrameStats;

    #[test]
    fn colour_and_mask_are_kept_apart() {
        let picture = Compared::from_rgba(UVec2::new(2, 1), &[1, 2, 3, 255, 4, 5, 6, 0]);
        assert_eq!(picture.rgb, [1, 2, 3, 4, 5, 6]);
        assert_eq!(picture.counts, [true, false]);
        assert_eq!(picture.clone().resized(UVec2::new(2, 1)), picture);
    }

    #[test]
    fn what_any_photograph_colours_counts() {
        use Surface::{Background, Completed, Inferred, MeshColoured, MeshUncoloured};
        let stats =
            FrameStats { pixels: 5, geometry_pixels: 2, coloured_pixels: 1, ..Default::default() };
        let stats = FrameStats { inferred_pixels: 1, completed_pixels: 1, ..stats };
        let frame = Frame {
            size: UVec2::new(5, 1),
            rgba: vec![255; 20],
            surfaces: vec![Background, MeshColoured, MeshUncoloured, Completed, Inferred],
            stats,
        };
        let rendering = Compared::from(&frame);
        assert_eq!(rendering.counts, [false, true, false, false, true]);
        assert_eq!((rendering.coverage, rendering.inferred), (Some(0.5), 0.2));
        let stats = FrameStats { geometry_pixels: 0, coloured_pixels: 0, ..stats };
        assert_eq!(Compared::from(&Frame { stats, ..frame }).coverage, None, "nothing to cover");
    }

    #[test]
    fn a_picture_is_stretched_to_another_size() {
        let grey = Compared::whole(image::RgbImage::from_pixel(8, 2, image::Rgb([9, 90, 200])));
        let stretched = grey.resized(UVec2::new(3, 5));
        assert_eq!(stretched.size, UVec2::new(3, 5));
        assert_eq!(stretched.counts, [true; 15]);
        assert!(stretched.rgb.chunks_exact(3).all(|pixel| pixel == [9, 90, 200]));
    }
}

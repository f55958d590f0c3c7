//! A photograph's levels of detail, and lookups between them.

use flaneur_scene::{ImageUpdate, linear_from_srgb, srgb_from_linear};
use glam::{DVec2, DVec3, UVec2};

use crate::photographs::atlas::MAX_LOD;

/// A photograph and its halves.
#[derive(Debug)]
pub(super) struct Pyramid {
    levels: Vec<Level>,
}

/// Colours in sRGB and mask, 0 to 1.
#[derive(Debug)]
struct Level {
    size: UVec2,
    texels: Vec<(DVec3, f64)>,
}

impl Pyramid {
    /// The levels of an image: the mean of four texels each, those outside the mask without a
    /// say in the colour, but hiding all of it, kept as bytes of sRGB.
    pub(super) fn new(image: &ImageUpdate) -> Self {
        let texels = image
            .rgba
            .chunks_exact(4)
            .map(|texel| {
                let channel = |i: usize| f64::from(texel[i]) / 255.0;
                let colour = DVec3::new(channel(0), channel(1), channel(2));
                (colour, channel(3))
            })
            .collect();
        let mut levels = vec![Level { size: image.size, texels }];
        let coarsest = image.size.min_element().ilog2().min(MAX_LOD);
        for _ in 0..coarsest {
            let next = levels.last().map(Level::halved);
            levels.extend(next);
        }
        Self { levels }
    }

    /// Linear colour and mask at a raw pixel position, where a pixel of the picture is as wide as
    /// `texels` of the full level, at least one. It lies between four texels of each of two levels, the
    /// one that halves the photograph ⌊log₂ texels⌋ times and the next; the share of the coarser one grows
    /// from 0 to 1 with `texels`, and the place is half a texel of it inside the border. The mask
    /// is 0 where any of them is hidden.
    ///
    /// What is between texels and levels is so of the bytes of sRGB: that is a decoding for each
    /// photograph and pixel instead of eight, and no byte of a photograph changes where it is shown as
    /// it is.
    pub(super) fn at(&self, pixel: DVec2, texels: f64) -> (DVec3, f64) {
        let texels = texels.clamp(1.0, self.coarsest());
        let fine = texels.log2().floor();
        let share = texels / fine.exp2() - 1.0;
        let inset = if share > 0.0 { fine.exp2() } else { 0.5 * fine.exp2() };
        let high = (self.levels[0].size.as_dvec2() - inset).max(DVec2::splat(inset));
        let inside = pixel.max(DVec2::splat(inset)).min(high);
        let of_level = |level: f64| self.levels[level as usize].at(inside / level.exp2());
        let (colour, mask) = of_level(fine);
        if share == 0.0 {
            return (colour.map(linear_from_srgb), mask);
        }
        let (coarser_colour, coarser_mask) = of_level(fine + 1.0);
        let shown = mask > 0.0 && coarser_mask > 0.0;
        let mask = if shown { mask + share * (coarser_mask - mask) } else { 0.0 };
        (colour.lerp(coarser_colour, share).map(linear_from_srgb), mask)
    }

    /// Size, colours in sRGB and mask of a level, row by row.
    #[cfg(test)]
    pub(super) fn level(&self, level: usize) -> (UVec2, &[(DVec3, f64)]) {
        (self.levels[level].size, &self.levels[level].texels)
    }

    /// How many texels of the full level are as wide as one of the coarsest.
    pub(super) fn coarsest(&self) -> f64 {
        ((self.levels.len() - 1) as f64).exp2()
    }
}

impl Level {
    fn texel(&self, x: i64, y: i64) -> (DVec3, f64) {
        let (width, height) = (i64::from(self.size.x), i64::from(self.size.y));
        let (x, y) = (x.clamp(0, width - 1), y.clamp(0, height - 1));
        self.texels[(y * width + x) as usize]
    }

    fn halved(&self) -> Self {
        let size = self.size.map(|side| side.div_ceil(2));
        let texel = |i: u32| {
            let (x, y) = (2 * i64::from(i % size.x), 2 * i64::from(i / size.x));
            let (mut colour, mut mask, mut shown) = (DVec3::ZERO, 0.0, true);
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                // Odd sizes: the last texel stands for one texel twice.
                let (c, m) = self.texel(x + dx, y + dy);
                colour += c.map(linear_from_srgb) * m;
                mask += m;
                shown &= m > 0.0;
            }
            let mean = if mask > 0.0 { colour / mask } else { colour };
            (mean.map(|c| byte(srgb_from_linear(c))), if shown { byte(mask / 4.0) } else { 0.0 })
        };
        Self { size, texels: (0..size.x * size.y).map(texel).collect() }
    }

    /// Bilinear, texel centres at halves.
    fn at(&self, position: DVec2) -> (DVec3, f64) {
        let first = (position - 0.5).floor();
        let t = position - 0.5 - first;
        let (x, y) = (first.x as i64, first.y as i64);
        let corners = [
            (self.texel(x, y), (1.0 - t.x) * (1.0 - t.y)),
            (self.texel(x + 1, y), t.x * (1.0 - t.y)),
            (self.texel(x, y + 1), (1.0 - t.x) * t.y),
            (self.texel(x + 1, y + 1), t.x * t.y),
        ];
        // A texel on whose centre it lies is alone.
        let shown = corners.iter().all(|((_, m), weight)| *m > 0.0 || *weight == 0.0);
        let sum = |(colour, mask), ((c, m), weight): ((DVec3, f64), f64)| {
            (colour + c * weight, mask + m * weight)
        };
        let (colour, mask) = corners.into_iter().fold((DVec3::ZERO, 0.0), sum);
        (colour, if shown { mask } else { 0.0 })
    }
}

/// The nearest of the 256 values that a byte keeps.
fn byte(value: f64) -> f64 {
    (value * 255.0).round() / 255.0
}

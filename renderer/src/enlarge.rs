//! Frames that were computed smaller than they are wanted.

use glam::UVec2;

use crate::Frame;

impl Frame {
    /// The same picture at `size`: colours interpolated between the four pixels around, what is
    /// shown taken from the nearest. Counts of pixels are those of the larger picture.
    pub(crate) fn enlarged(self, size: UVec2) -> Self {
        if self.size == size || self.size.min_element() == 0 {
            return self;
        }
        let columns = samples(size.x, self.size.x);
        let width = self.size.x as usize;
        let mut rgba = Vec::with_capacity(size.element_product() as usize * 4);
        let mut surfaces = Vec::with_capacity(size.element_product() as usize);
        let row = |y: u32| self.rgba.chunks_exact(4 * width).nth(y as usize).unwrap_or_default();
        for Sample { at: [above, below], share: down, nearest } in samples(size.y, self.size.y) {
            let (top, bottom) = (row(above), row(below));
            let shown = self.surfaces.chunks_exact(width).nth(nearest as usize).unwrap_or_default();
            for Sample { at: [left, right], share: along, nearest } in &columns {
                let [left, right] = [*left, *right].map(|x| 4 * x as usize);
                for channel in 0..4 {
                    let mixed = |row: &[u8]| {
                        let [a, b] = [row[left + channel], row[right + channel]].map(f32::from);
                        a + (b - a) * along
                    };
                    let (a, b) = (mixed(top), mixed(bottom));
                    rgba.push((a + (b - a) * down).round() as u8);
                }
                surfaces.push(shown[*nearest as usize]);
            }
        }
        let stats = self.stats.counting(&surfaces);
        Self { size, rgba, surfaces, stats }
    }
}

/// Where a pixel of the larger picture lies between the pixels of the smaller one.
struct Sample {
    at: [u32; 2],
    /// How far it is from the first to the second, 0 to 1.
    share: f32,
    nearest: u32,
}

fn samples(large: u32, small: u32) -> Vec<Sample> {
    let last = small.saturating_sub(1);
    let sample = |pixel: u32| {
        let place = (f64::from(pixel) + 0.5) * f64::from(small) / f64::from(large);
        let between = (place - 0.5).clamp(0.0, f64::from(last));
        let (first, share) = (between.floor() as u32, between.fract() as f32);
        Sample { at: [first, (first + 1).min(last)], share, nearest: (place as u32).min(last) }
    };
    (0..large).map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerances::ENLARGED_255;
    use crate::{FrameStats, Surface};

    /// A picture whose red grows along x and whose green grows along y stays so.
    #[test]
    fn slopes_are_kept() {
        let small = UVec2::new(8, 4);
        let rgba = (0..small.y)
            .flat_map(|y| (0..small.x).flat_map(move |x| [16 * x as u8, 32 * y as u8, 7, 255]))
            .collect();
        let surfaces = (0..32).map(|i| match i % 8 {
            0..4 => Surface::Background,
            _ => Surface::MeshColoured,
        });
        let frame =
            Frame { size: small, rgba, surfaces: surfaces.collect(), stats: FrameStats::default() };
        let size = UVec2::new(24, 12);
        let large = frame.clone().enlarged(size);
        assert_eq!((large.size, large.rgba.len()), (size, 4 * 24 * 12));
        for y in 0..size.y {
            for x in 0..size.x {
                let i = (y * size.x + x) as usize;
                let exact = |pixel: u32, step: f32, most: f32| {
                    (((pixel as f32 + 0.5) / 3.0 - 0.5) * step).clamp(0.0, most)
                };
                let [r, g, b, a] = [0, 1, 2, 3].map(|c| f32::from(large.rgba[4 * i + c]));
                assert!(
                    f64::from((r - exact(x, 16.0, 112.0)).abs()) <= ENLARGED_255,
                    "{x} {y}: {r}"
                );
                assert!(
                    f64::from((g - exact(y, 32.0, 96.0)).abs()) <= ENLARGED_255,
                    "{x} {y}: {g}"
                );
                assert_eq!((b, a), (7.0, 255.0));
                assert_eq!(large.surfaces[i].is_geometry(), x >= 12, "{x} {y}");
            }
        }
        assert_eq!(large.stats.coloured_pixels, 144);
        assert_eq!(frame.clone().enlarged(small), frame);
    }
}

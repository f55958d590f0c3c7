//! The stored levels of a photograph: the original and its halves.
//!
//! A level is half the one above, rounded up, each pixel the mean of the light on the area
//! that it covers: sRGB is undone, averaged, and applied again. Image corners stay image
//! corners, so a lens scales exactly ([`flaneur_scene::Lens::scaled_to`]).

use flaneur_scene::{linear_from_srgb, srgb_from_linear};
use glam::UVec2;
use jpeg_encoder::{ChromaSubsamplingMethod, ColorType, Encoder};

/// The last level is the first whose longer side is not above this: a few kilobytes.
const LAST_SIDE: u32 = 100;
/// JPEG quality of the halves.
const QUALITY: u8 = 85;
/// JPEG quality of level 0 where the original is no JPEG.
const ORIGINAL_QUALITY: u8 = 95;

/// Changes whenever the same original would give other bytes: part of an image's version.
pub(super) const ENCODER_VERSION: &str = "flaneur pyramid 2";

/// An image in linear light, RGB.
pub(super) struct LinearImage {
    size: UVec2,
    samples: Vec<f32>,
}

/// Number of levels of an image of `size`, the original included.
pub(super) fn level_count(size: UVec2) -> u32 {
    let mut side = size.max_element();
    let mut levels = 1;
    while side > LAST_SIDE {
        side = side.div_ceil(2);
        levels += 1;
    }
    levels
}

/// Half of an image of sRGB bytes.
pub(super) fn halve_srgb(size: UVec2, rgb: &[u8]) -> LinearImage {
    let linear: [f32; 256] = std::array::from_fn(|i| linear_from_srgb(i as f64 / 255.0) as f32);
    halve(size, rgb, |byte| linear[usize::from(byte)])
}

impl LinearImage {
    /// Half of the image.
    pub(super) fn halve(&self) -> Self {
        halve(self.size, &self.samples, |sample| sample)
    }

    /// The image as a JPEG.
    pub(super) fn encode(&self, table: &SrgbTable) -> Result<Vec<u8>, String> {
        let rgb: Vec<u8> = self.samples.iter().map(|&sample| table.byte(sample)).collect();
        encode(self.size, &rgb, QUALITY)
    }
}

/// Level 0 of an original that is no JPEG.
pub(super) fn encode_original(size: UVec2, rgb: &[u8]) -> Result<Vec<u8>, String> {
    encode(size, rgb, ORIGINAL_QUALITY)
}

/// Linear light to sRGB bytes, by table: 65 536 steps are at most 0.05 of a byte apart.
pub(super) struct SrgbTable(Vec<u8>);

impl SrgbTable {
    pub(super) fn new() -> Self {
        let byte = |i: u32| (srgb_from_linear(f64::from(i) / 65535.0) * 255.0).round() as u8;
        Self((0..=65535).map(byte).collect())
    }

    fn byte(&self, linear: f32) -> u8 {
        // The cast saturates: averages may exceed 1 by rounding.
        let index = (linear * 65535.0 + 0.5) as u16;
        self.0[usize::from(index)]
    }
}

fn encode(size: UVec2, rgb: &[u8], quality: u8) -> Result<Vec<u8>, String> {
    let [Ok(width), Ok(height)] = size.to_array().map(u16::try_from) else {
        return Err(format!("{}×{} pixels are too many for a JPEG", size.x, size.y));
    };
    let mut jpeg = Vec::new();
    let mut encoder = Encoder::new(&mut jpeg, quality);
    encoder.set_chroma_subsampling_method(ChromaSubsamplingMethod::Average);
    // Optimised tables would save 2 %, but this encoder then writes a scan for each colour,
    // which zune-jpeg decodes wrongly where the colours are subsampled.
    encoder.encode(rgb, width, height, ColorType::Rgb).map_err(|e| e.to_string())?;
    Ok(jpeg)
}

/// The source pixels that a pixel of the half covers, along one axis.
struct Taps {
    first: usize,
    weights: [f32; 3],
}

/// For each pixel of the half, its at most three source pixels and their shares. The half
/// of an odd side is rounded up, so its pixels cover a little less than two.
fn taps(side: u32) -> Vec<Taps> {
    let half = side.div_ceil(2);
    let step = f64::from(side) / f64::from(half);
    (0..half)
        .map(|i| {
            let (start, end) = (f64::from(i) * step, f64::from(i + 1) * step);
            let first = start as u32;
            let share = |j: u32| {
                let low = start.max(f64::from(first + j));
                let high = end.min(f64::from(first + j + 1));
                ((high - low).max(0.0) / step) as f32
            };
            Taps { first: first as usize, weights: [share(0), share(1), share(2)] }
        })
        .collect()
}

fn halve<S: Copy>(size: UVec2, samples: &[S], linear: impl Fn(S) -> f32) -> LinearImage {
    let width = size.x as usize;
    let (columns, rows) = (taps(size.x), taps(size.y));
    let mut half = Vec::with_capacity(3 * columns.len() * rows.len());
    for row in &rows {
        for column in &columns {
            let mut sum = [0.0_f32; 3];
            // A share of zero may lie beyond the border.
            for (j, &wy) in row.weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                for (i, &wx) in column.weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                    // Rounding may leave a last crumb of a share beyond the border.
                    let y = (row.first + j).min(size.y as usize - 1);
                    let x = (column.first + i).min(width - 1);
                    let at = 3 * (y * width + x);
                    for (sum, &sample) in sum.iter_mut().zip(&samples[at..at + 3]) {
                        *sum += wy * wx * linear(sample);
                    }
                }
            }
            half.extend_from_slice(&sum);
        }
    }
    LinearImage { size: UVec2::new(columns.len() as u32, rows.len() as u32), samples: half }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with flat, smooth and hard parts.
    fn picture(size: UVec2) -> Vec<u8> {
        let pixel = |i: u32| {
            let (x, y) = (i % size.x, i / size.x);
            let hash = (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(40503)) >> 7;
            [(x * 255 / size.x) as u8, if (x / 3 + y / 2) % 2 == 0 { 255 } else { 0 }, hash as u8]
        };
        (0..size.x * size.y).flat_map(pixel).collect()
    }

    /// The mean light of the exact area, integrated in f64 on a grid common to both sizes.
    fn reference(size: UVec2, rgb: &[u8], half: UVec2, x: u32, y: u32, channel: usize) -> f64 {
        let span = |i: u32, side: u32, half: u32| {
            (
                f64::from(i) * f64::from(side) / f64::from(half),
                f64::from(i + 1) * f64::from(side) / f64::from(half),
            )
        };
        let ((x0, x1), (y0, y1)) = (span(x, size.x, half.x), span(y, size.y, half.y));
        let overlap =
            |a: f64, b: f64, i: u32| (b.min(f64::from(i + 1)) - a.max(f64::from(i))).max(0.0);
        let mut sum = 0.0;
        for v in 0..size.y {
            for u in 0..size.x {
                let area = overlap(x0, x1, u) * overlap(y0, y1, v);
                let byte = rgb[3 * (v * size.x + u) as usize + channel];
                sum += area * linear_from_srgb(f64::from(byte) / 255.0);
            }
        }
        srgb_from_linear(sum / ((x1 - x0) * (y1 - y0))) * 255.0
    }

    #[test]
    fn halves_are_the_mean_light_of_their_area() {
        let table = SrgbTable::new();
        for size in [
            UVec2::new(16, 10),
            UVec2::new(17, 11),
            UVec2::new(1, 1),
            UVec2::new(3, 1),
            UVec2::new(2, 9),
        ] {
            let rgb = picture(size);
            let half = halve_srgb(size, &rgb);
            assert_eq!(half.size, size.map(|side| side.div_ceil(2)));
            for (i, &sample) in half.samples.iter().enumerate() {
                let (pixel, channel) = ((i / 3) as u32, i % 3);
                let (x, y) = (pixel % half.size.x, pixel / half.size.x);
                let expected = reference(size, &rgb, half.size, x, y, channel);
                let found = f64::from(table.byte(sample));
                // Half a byte of rounding, and the table's 0.05.
                assert!((found - expected).abs() <= 0.56, "{size} {x},{y}: {found} {expected}");
            }
        }
    }

    #[test]
    fn every_byte_survives_linear_light() {
        let table = SrgbTable::new();
        for byte in 0..=255_u8 {
            assert_eq!(table.byte(linear_from_srgb(f64::from(byte) / 255.0) as f32), byte);
        }
    }

    #[test]
    fn a_checkerboard_keeps_its_light() {
        let size = UVec2::new(32, 32);
        let rgb: Vec<u8> = (0..32 * 32)
            .flat_map(|i| [if (i % 32 + i / 32) % 2 == 0 { 255 } else { 0 }; 3])
            .collect();
        let half = halve_srgb(size, &rgb);
        // Half the light is sRGB 188, where a mean of bytes would give 128.
        assert_eq!(SrgbTable::new().byte(half.samples[0]), 188);
    }

    #[test]
    fn levels_end_at_a_few_kilobytes() {
        assert_eq!(level_count(UVec2::new(1024, 1024)), 5);
        assert_eq!(level_count(UVec2::new(1242, 375)), 5);
        assert_eq!(level_count(UVec2::new(100, 10)), 1);
        assert_eq!(level_count(UVec2::new(101, 10)), 2);
        assert_eq!(level_count(UVec2::new(23_170, 11_585)), 9);
    }
}

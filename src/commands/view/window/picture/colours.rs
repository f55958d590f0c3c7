//! The mere colours of a picture.

use glam::UVec2;

/// How many there are, in columns and rows.
pub(super) const SIZE: UVec2 = UVec2::new(16, 9);
/// A colour is the mean of so many pixels squared of its part of the picture.
const SAMPLES: u32 = 8;

/// The colours of a picture of `size` pixels, RGBA, as RGBA of [`SIZE`]; black where it lacks pixels.
pub(super) fn colours(rgba: &[u8], size: UVec2) -> Vec<u8> {
    let (pixels, _) = rgba.as_chunks::<4>();
    let across = SIZE * SAMPLES;
    let pixel = |sample: UVec2| {
        let at = |sample: u32, all: u32, side: u32| {
            (u64::from(2 * sample + 1) * u64::from(side) / u64::from(2 * all)) as usize
        };
        let (x, y) = (at(sample.x, across.x, size.x), at(sample.y, across.y, size.y));
        pixels.get(y * size.x as usize + x).copied().unwrap_or_default()
    };
    let colour = |cell: UVec2| {
        let mut sum = [0; 3];
        for index in 0..SAMPLES * SAMPLES {
            let sample = cell * SAMPLES + UVec2::new(index % SAMPLES, index / SAMPLES);
            let [r, g, b, _] = pixel(sample).map(u32::from);
            sum = [sum[0] + r, sum[1] + g, sum[2] + b];
        }
        let [r, g, b] = sum.map(|sum| (sum / (SAMPLES * SAMPLES)) as u8);
        [r, g, b, u8::MAX]
    };
    let cells = (0..SIZE.x * SIZE.y).map(|index| UVec2::new(index % SIZE.x, index / SIZE.x));
    cells.flat_map(colour).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_where_the_picture_has_them() {
        let size = UVec2::new(320, 180);
        let pixels = (0..size.x * size.y).flat_map(|index| {
            let (x, y) = (index % size.x, index / size.x);
            [if x < 160 { 200 } else { 0 }, if y < 90 { 100 } else { 50 }, 7, 255]
        });
        let found = colours(&pixels.collect::<Vec<_>>(), size);
        let at = |x: usize, y: usize| &found[4 * (y * 16 + x)..][..4];
        assert_eq!((at(0, 0), at(7, 3)), (&[200, 100, 7, 255][..], &[200, 100, 7, 255][..]));
        assert_eq!((at(8, 0), at(15, 8)), (&[0, 100, 7, 255][..], &[0, 50, 7, 255][..]));
        assert_eq!(at(0, 4), &[200, 75, 7, 255], "half of each");
        // Pictures smaller than that, and such as lack pixels, are no harm.
        assert_eq!(colours(&[9, 9, 9, 9], UVec2::ONE)[..4], [9, 9, 9, 255]);
        assert_eq!(colours(&[], size)[..4], [0, 0, 0, 255]);
    }
}

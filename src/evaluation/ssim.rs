//! Structural similarity (Wang, Bovik, Sheikh, Simoncelli, 2004), as scikit-image's
//! `structural_similarity` computes it by default for colours in [0, 1]: windows of 7×7 pixels of
//! equal weight, sample covariance, K1 = 0.01 and K2 = 0.03, the mean over the windows that lie
//! wholly in the picture and over the channels.

use glam::UVec2;

/// Pixels a side of a window.
const WINDOW: usize = 7;
/// Pixels of a window.
const COUNT: f64 = (WINDOW * WINDOW) as f64;
/// (K L)², with L = 255: the sums below are of bytes.
const C1: f64 = 0.01 * 255.0 * (0.01 * 255.0);
const C2: f64 = 0.03 * 255.0 * (0.03 * 255.0);

/// The similarity at each window of two pictures.
#[derive(Clone, Debug)]
pub(crate) struct SsimMap {
    /// Size of the pictures, pixels.
    size: UVec2,
    /// Mean over the channels, windows in rows from the top: 6 fewer each way than pixels.
    values: Vec<f64>,
}

impl SsimMap {
    /// Compares two pictures of `size` with three bytes a pixel; `None` where they are smaller
    /// than a window, or hold fewer bytes than that.
    ///
    /// Sums are of integers and so exact, and slide along with the window: the cost is
    /// proportional to the pixels.
    pub(crate) fn new(a: &[u8], b: &[u8], size: UVec2) -> Option<Self> {
        let [width, height] = [size.x as usize, size.y as usize];
        let stride = width.checked_mul(3)?;
        let bytes = stride.checked_mul(height)?;
        let (a, b) = (a.get(..bytes)?, b.get(..bytes)?);
        if width < WINDOW || height < WINDOW {
            return None;
        }
        let columns = width - WINDOW + 1;
        let mut values = vec![0.0; columns * (height - WINDOW + 1)];
        // The sums of each column's bytes over the rows of a window.
        let mut below = vec![Sums::default(); stride];
        let row = |y: usize| y * stride..(y + 1) * stride;
        for y in 0..height {
            for ((sums, &a), &b) in below.iter_mut().zip(&a[row(y)]).zip(&b[row(y)]) {
                sums.add(&Sums::of(a, b));
            }
            if let Some(gone) = y.checked_sub(WINDOW) {
                for ((sums, &a), &b) in below.iter_mut().zip(&a[row(gone)]).zip(&b[row(gone)]) {
                    sums.subtract(&Sums::of(a, b));
                }
            }
            let Some(top) = (y + 1).checked_sub(WINDOW) else { continue };
            let out = &mut values[top * columns..(top + 1) * columns];
            for channel in 0..3 {
                let mut window = Sums::default();
                for x in 0..width {
                    window.add(&below[3 * x + channel]);
                    if let Some(gone) = x.checked_sub(WINDOW) {
                        window.subtract(&below[3 * gone + channel]);
                    }
                    if let Some(left) = (x + 1).checked_sub(WINDOW) {
                        out[left] += window.similarity() / 3.0;
                    }
                }
            }
        }
        Some(Self { size, values })
    }

    /// The mean over all windows.
    pub(crate) fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// The mean over the windows all of whose pixels `counts` holds for; NaN where there are
    /// none.
    pub(crate) fn mean_where(&self, counts: impl Fn(usize) -> bool) -> f64 {
        let width = self.size.x as usize;
        let columns = width - WINDOW + 1;
        // How many of the last pixels of each column count, without a gap.
        let mut runs = vec![0_usize; width];
        let (mut sum, mut windows) = (0.0, 0_u64);
        for y in 0..self.size.y as usize {
            for (x, run) in runs.iter_mut().enumerate() {
                *run = if counts(y * width + x) { *run + 1 } else { 0 };
            }
            let Some(top) = (y + 1).checked_sub(WINDOW) else { continue };
            let mut whole = 0;
            for (x, &run) in runs.iter().enumerate() {
                whole = if run >= WINDOW { whole + 1 } else { 0 };
                if whole >= WINDOW {
                    sum += self.values[top * columns + (x + 1 - WINDOW)];
                    windows += 1;
                }
            }
        }
        sum / windows as f64
    }
}

/// Sums over pixels of both pictures, their squares and their product.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    a: u32,
    b: u32,
    aa: u32,
    bb: u32,
    ab: u32,
}

impl Sums {
    fn of(a: u8, b: u8) -> Self {
        let (a, b) = (u32::from(a), u32::from(b));
        Self { a, b, aa: a * a, bb: b * b, ab: a * b }
    }

    fn add(&mut self, other: &Self) {
        self.a += other.a;
        self.b += other.b;
        self.aa += other.aa;
        self.bb += other.bb;
        self.ab += other.ab;
    }

    fn subtract(&mut self, other: &Self) {
        self.a -= other.a;
        self.b -= other.b;
        self.aa -= other.aa;
        self.bb -= other.bb;
        self.ab -= other.ab;
    }

    /// Equation 13 of the paper, for the sums of a whole window.
    fn similarity(&self) -> f64 {
        let mean = |sum: u32| f64::from(sum) / COUNT;
        let (a, b) = (mean(self.a), mean(self.b));
        let sample = COUNT / (COUNT - 1.0);
        let covariance = |product: u32, a: f64, b: f64| sample * (mean(product) - a * b);
        let (aa, bb) = (covariance(self.aa, a, a), covariance(self.bb, b, b));
        let ab = covariance(self.ab, a, b);
        (2.0 * a * b + C1) * (2.0 * ab + C2) / ((a * a + b * b + C1) * (aa + bb + C2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::squared_error::{mean_squared_error, psnr_db};

    /// Ramps with noise, the same as those from which the stored values were computed:
    /// `n = 73856093 x ^ 19349663 y ^ 83492791 (c + 1) ^ 2654435761 seed`, `n = n² + 7 n`, all
    /// modulo 2³², value `(3 x + 2 y (c + 1)) mod 224 + (n >> 16) mod 32`.
    fn picture(size: UVec2, seed: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (y, x) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (y, x))) {
            for channel in 1..=3_u32 {
                let n = x.wrapping_mul(73_856_093)
                    ^ y.wrapping_mul(19_349_663)
                    ^ channel.wrapping_mul(83_492_791)
                    ^ seed.wrapping_mul(2_654_435_761);
                let n = n.wrapping_mul(n).wrapping_add(n.wrapping_mul(7));
                let value = (3 * x + 2 * y * channel) % 224 + (n >> 16) % 32;
                bytes.push(u8::try_from(value).expect("below 256"));
            }
        }
        bytes
    }

    fn compared(size: UVec2, b: &[u8]) -> f64 {
        SsimMap::new(&picture(size, 1), b, size).expect("large enough").mean()
    }

    /// `structural_similarity(a / 255, b / 255, data_range=1.0, channel_axis=2)` and
    /// `peak_signal_noise_ratio(a / 255, b / 255, data_range=1.0)` of scikit-image 0.26.0. Both
    /// sides compute in f64; the tolerance is for another order of summation.
    #[test]
    fn values_are_those_of_scikit_image() {
        for (width, height, ssim, psnr) in [
            (7, 7, 0.594_630_932_517_751_5, 25.928_655_009_817_36),
            (8, 9, 0.603_682_912_361_443_2, 25.865_997_968_395_902),
            (40, 23, 0.598_997_074_634_368_1, 25.789_079_972_454_267),
            (64, 48, 0.656_206_618_160_006_5, 25.796_083_112_698_74),
        ] {
            let size = UVec2::new(width, height);
            let (a, b) = (picture(size, 1), picture(size, 2));
            let found = compared(size, &b);
            assert!((found - ssim).abs() < 1e-12, "{size}: {found}, must be {ssim}");
            let found = psnr_db(mean_squared_error(&a, &b, |_| true));
            assert!((found - psnr).abs() < 1e-10, "{size}: {found}, must be {psnr}");
        }
    }

    /// Against the picture moved by two columns and inverted, and against plain grey.
    #[test]
    fn unlike_pictures_have_the_values_of_scikit_image() {
        let size = UVec2::new(40, 23);
        let a = picture(size, 1);
        let inverted: Vec<u8> = a
            .chunks_exact(3 * 40)
            .flat_map(|row| (0..40).flat_map(move |x| &row[3 * ((x + 38) % 40)..][..3]))
            .map(|value| 255 - value)
            .collect();
        let found = compared(size, &inverted);
        assert!((found - -0.262_416_275_468_001_7).abs() < 1e-12, "{found}");
        let found = compared(size, &vec![128; a.len()]);
        assert!((found - 0.222_280_331_110_162_18).abs() < 1e-12, "{found}");
        assert!((compared(size, &a) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn masked_windows_are_left_out() {
        let size = UVec2::new(40, 23);
        let map = SsimMap::new(&picture(size, 1), &picture(size, 2), size).expect("large");
        // The mean of scikit-image's map over the windows left of column 25.
        let left = map.mean_where(|pixel| pixel % 40 < 25);
        assert!((left - 0.597_789_613_587_169_4).abs() < 1e-12, "{left}");
        assert!((map.mean_where(|_| true) - map.mean()).abs() < 1e-14);
        // A grid of holes too fine for any window.
        assert!(map.mean_where(|pixel| !(pixel % 40).is_multiple_of(6)).is_nan());
    }

    #[test]
    fn what_is_smaller_than_a_window_has_no_value() {
        for size in [UVec2::new(6, 100), UVec2::new(100, 6), UVec2::ZERO, UVec2::MAX] {
            assert!(SsimMap::new(&[0; 1800], &[0; 1800], size).is_none(), "{size}");
        }
        assert!(SsimMap::new(&[0; 147], &[0; 146], UVec2::splat(7)).is_none());
        assert!(SsimMap::new(&[0; 147], &[0; 147], UVec2::splat(7)).is_some());
    }
}

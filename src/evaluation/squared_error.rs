//! RMSE and PSNR.

/// The mean squared difference of pictures of three bytes a pixel, over the pixels that `counts`
/// holds for, with values in [0, 1]; NaN where there are none.
///
/// The sum is of integers, and so exact, for any picture that memory holds.
pub(crate) fn mean_squared_error(a: &[u8], b: &[u8], counts: impl Fn(usize) -> bool) -> f64 {
    let (mut sum, mut values) = (0_u64, 0_u64);
    for (index, (a, b)) in a.chunks_exact(3).zip(b.chunks_exact(3)).enumerate() {
        if counts(index) {
            values += 3;
            sum += a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum::<u64>();
        }
    }
    sum as f64 / values as f64 / (255.0 * 255.0)
}

/// Peak signal-to-noise ratio in dB for a peak of 1: `10 log10(1 / mse)`. Infinite where the
/// pictures are the same.
pub(crate) fn psnr_db(mean_squared_error: f64) -> f64 {
    -10.0 * mean_squared_error.log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_error_has_its_known_ratio() {
        let (a, b) = ([10_u8; 12], [61_u8; 12]);
        // A fifth of the range everywhere: 10 log10(25).
        let error = mean_squared_error(&a, &b, |_| true);
        assert!((error - 0.04).abs() < 1e-15, "{error}");
        assert!((psnr_db(error) - 13.979_400_086_720_377).abs() < 1e-12);
        assert_eq!(psnr_db(mean_squared_error(&a, &a, |_| true)), f64::INFINITY);
    }

    #[test]
    fn only_what_counts_is_measured() {
        let (a, b) = ([0_u8; 6], [0, 0, 0, 255, 255, 255]);
        assert_eq!(mean_squared_error(&a, &b, |pixel| pixel == 0), 0.0);
        assert_eq!(mean_squared_error(&a, &b, |pixel| pixel == 1), 1.0);
        assert_eq!(mean_squared_error(&a, &b, |_| true), 0.5);
        assert!(mean_squared_error(&a, &b, |_| false).is_nan());
        assert!(psnr_db(mean_squared_error(&[], &[], |_| true)).is_nan());
    }
}

//! How far a rendering is from a photograph.

use serde::Serialize;

use super::Compared;
use super::compared::share;
use super::squared_error::{mean_squared_error, psnr_db};
use super::ssim::SsimMap;

/// The figures of one rendering, or the means of several. What there is nothing to measure on is
/// NaN, and the PSNR of equal pictures infinite: both are `null` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Score {
    /// Peak signal-to-noise ratio over the whole frame, dB.
    pub(crate) psnr_db: f64,
    /// Structural similarity over the whole frame, -1 to 1.
    pub(crate) ssim: f64,
    /// Root of the mean squared error over the whole frame, 0 to 1.
    pub(crate) rmse: f64,
    /// Share of the pixels showing geometry (mesh or points) that at least one source colours.
    /// There is none where no pixel shows geometry, as for a method that shows a source unwarped.
    pub(crate) coverage: f64,
    /// Share of all pixels that sources colour at an inferred depth, where there is no geometry.
    pub(crate) inferred: f64,
    /// Share of all pixels that no source colours: background, geometry without a photograph, and
    /// colours that go on from around. With those that sources colour, on geometry or at an
    /// inferred depth, they are all; of a source shown unwarped, those that its mask hides.
    pub(crate) unseen: f64,
    /// Share of all pixels that the photograph's mask hides.
    pub(crate) masked: f64,
    /// As `psnr_db`, over the pixels that the mask shows.
    pub(crate) psnr_db_unmasked: f64,
    /// As `ssim`, over the windows that the mask shows whole.
    pub(crate) ssim_unmasked: f64,
    /// As `rmse`, over the pixels that the mask shows.
    pub(crate) rmse_unmasked: f64,
    /// As `psnr_db`, over the pixels that the mask shows and a source colours, be it at an
    /// inferred depth: those that are not `unseen`.
    pub(crate) psnr_db_covered: f64,
    /// As `ssim`, over the windows all of whose pixels are among those.
    pub(crate) ssim_covered: f64,
    /// As `rmse`, over the pixels of `psnr_db_covered`.
    pub(crate) rmse_covered: f64,
}

impl Score {
    /// The score of `rendering` against `photograph`; `None` where their sizes differ.
    pub(crate) fn new(photograph: &Compared, rendering: &Compared) -> Option<Self> {
        if photograph.size != rendering.size {
            return None;
        }
        let (a, b) = (&photograph.rgb, &rendering.rgb);
        let map = SsimMap::new(a, b, photograph.size);
        let shown = |pixel: usize| photograph.counts.get(pixel) == Some(&true);
        let covered = |pixel: usize| shown(pixel) && rendering.counts.get(pixel) == Some(&true);
        let errors = [
            mean_squared_error(a, b, |_| true),
            mean_squared_error(a, b, shown),
            mean_squared_error(a, b, covered),
        ];
        let similarities = map.map_or([f64::NAN; 3], |map| {
            [map.mean(), map.mean_where(shown), map.mean_where(covered)]
        });
        Some(Self {
            psnr_db: psnr_db(errors[0]),
            ssim: similarities[0],
            rmse: errors[0].sqrt(),
            coverage: rendering.coverage.unwrap_or(f64::NAN),
            inferred: rendering.inferred,
            unseen: 1.0 - share(&rendering.counts),
            masked: 1.0 - share(&photograph.counts),
            psnr_db_unmasked: psnr_db(errors[1]),
            ssim_unmasked: similarities[1],
            rmse_unmasked: errors[1].sqrt(),
            psnr_db_covered: psnr_db(errors[2]),
            ssim_covered: similarities[2],
            rmse_covered: errors[2].sqrt(),
        })
    }

    /// The mean of each figure over the scores that have it.
    pub(crate) fn mean(scores: &[Self]) -> Self {
        let mean = |figure: fn(&Self) -> f64| {
            let (mut sum, mut count) = (0.0, 0.0);
            for value in scores.iter().map(figure).filter(|value| !value.is_nan()) {
                sum += value;
                count += 1.0;
            }
            sum / count
        };
        Self {
            psnr_db: mean(|s| s.psnr_db),
            ssim: mean(|s| s.ssim),
            rmse: mean(|s| s.rmse),
            coverage: mean(|s| s.coverage),
            inferred: mean(|s| s.inferred),
            unseen: mean(|s| s.unseen),
            masked: mean(|s| s.masked),
            psnr_db_unmasked: mean(|s| s.psnr_db_unmasked),
            ssim_unmasked: mean(|s| s.ssim_unmasked),
            rmse_unmasked: mean(|s| s.rmse_unmasked),
            psnr_db_covered: mean(|s| s.psnr_db_covered),
            ssim_covered: mean(|s| s.ssim_covered),
            rmse_covered: mean(|s| s.rmse_covered),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    fn grey(side: u32, value: u8, counts: impl Fn(usize) -> bool) -> Compared {
        let pixels = (side * side) as usize;
        let counts: Vec<bool> = (0..pixels).map(counts).collect();
        let (rgb, coverage) = (vec![value; 3 * pixels], Some(share(&counts)));
        Compared { size: UVec2::splat(side), rgb, counts, coverage, inferred: 0.0 }
    }

    #[test]
    fn masked_and_uncovered_pixels_are_told_apart() {
        // The mask hides the right half, where the photograph is black; no source sees the
        // last rows, where the rendering is black.
        let mut photograph = grey(16, 100, |pixel| pixel % 16 < 8);
        let mut rendering = grey(16, 100, |pixel| pixel / 16 < 12);
        for pixel in 0..256 {
            if pixel % 16 >= 8 {
                photograph.rgb[3 * pixel..3 * pixel + 3].fill(0);
            }
            if pixel / 16 >= 12 {
                rendering.rgb[3 * pixel..3 * pixel + 3].fill(0);
            }
        }
        let score = Score::new(&photograph, &rendering).expect("of one size");
        assert_eq!((score.coverage, score.masked, score.unseen), (0.75, 0.5, 0.25));
        assert_eq!((score.rmse_covered, score.psnr_db_covered), (0.0, f64::INFINITY));
        assert!((score.ssim_covered - 1.0).abs() < 1e-12);
        // A quarter of what the mask shows is wrong; of the whole, a half.
        let wrong = 100.0 / 255.0;
        assert!((score.rmse_unmasked - wrong * 0.5).abs() < 1e-12);
        assert!((score.rmse - wrong * 0.5_f64.sqrt()).abs() < 1e-12);
        assert!(score.ssim_unmasked < 0.9 && score.ssim < score.ssim_unmasked);
    }

    #[test]
    fn what_cannot_be_measured_is_left_out_of_the_mean() {
        let photograph = grey(5, 100, |_| true);
        let small = Score::new(&photograph, &grey(5, 151, |_| false)).expect("of one size");
        assert!(small.ssim.is_nan() && small.psnr_db_covered.is_nan());
        let large = Score::new(&grey(8, 100, |_| true), &grey(8, 202, |_| true));
        let large = large.expect("of one size");
        let mean = Score::mean(&[small, large]);
        assert!((mean.rmse - 0.3).abs() < 1e-12 && (mean.unseen - 0.5).abs() < 1e-12);
        let unwarped = Compared { coverage: None, ..grey(5, 100, |_| true) };
        let unwarped = Score::new(&photograph, &unwarped).expect("of one size");
        assert!(unwarped.coverage.is_nan() && unwarped.unseen == 0.0);
        assert_eq!(Score::mean(&[unwarped, large]).coverage, 1.0);
        assert!((mean.rmse_covered - 0.4).abs() < 1e-12 && mean.ssim > 0.0);
        assert_eq!(Score::new(&photograph, &grey(8, 0, |_| true)), None);
    }
}

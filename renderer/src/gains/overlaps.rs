//! How much brighter one photograph is than another, from the places that both see.
//!
//! For each two photographs the median of the logarithms of their ratios, channel by channel: up
//! to half of the places may be wrong, where a car drove through one of the photographs, a
//! window mirrors the sky, or the geometry is not as it is thought to be.

use super::measure::Samples;

/// Fewer places say nothing.
pub(super) const LEAST_PLACES: usize = 12;
/// Linear. Darker is noise, and the foot of the camera's curve.
pub(super) const DARKEST: f32 = 0.01;
/// Linear. Brighter may be cut off, and is bent by the shoulder of the camera's curve.
pub(super) const BRIGHTEST: f32 = 0.8;
/// Standard deviation, of a logarithm, that no number of places reduces: lenses darken towards
/// their borders, and surfaces shine differently in different directions.
pub(super) const SYSTEMATIC: f64 = 0.03;
/// Ratio of the variance of a median to that of a mean, of normally distributed values.
pub(super) const MEDIAN_VARIANCE: f64 = std::f64::consts::FRAC_PI_2;
/// From the median of absolute deviations to a standard deviation, for the normal distribution.
pub(super) const NORMAL_DEVIATION: f64 = 1.4826;

/// Two photographs that see the same places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlap {
    pub(crate) a: usize,
    pub(crate) b: usize,
    /// `ln(colour of b / colour of a)` in each channel.
    pub(crate) log_ratio: [f64; 3],
    /// Variance of the mean of the three.
    pub(crate) variance: f64,
}

/// The overlaps of all photographs, in their order.
pub(crate) fn overlaps(samples: &Samples) -> Vec<Overlap> {
    let logs: Vec<Vec<Option<[f32; 3]>>> = samples
        .colours
        .iter()
        .map(|places| places.iter().map(|colour| colour.and_then(usable_log)).collect())
        .collect();
    let mut found = Vec::new();
    for b in 1..logs.len() {
        for a in 0..b {
            let lent = |by: usize| by * samples.places_each..(by + 1) * samples.places_each;
            let ratios: Vec<[f64; 3]> = lent(a)
                .chain(lent(b))
                .filter_map(|place| {
                    let (a, b) = (logs[a].get(place)?.as_ref()?, logs[b].get(place)?.as_ref()?);
                    Some([0, 1, 2].map(|channel| f64::from(b[channel] - a[channel])))
                })
                .collect();
            found.extend(overlap(a, b, &ratios));
        }
    }
    found
}

fn usable_log(colour: [f32; 3]) -> Option<[f32; 3]> {
    // Written so that NaN is refused.
    let usable = colour.iter().all(|c| (DARKEST..=BRIGHTEST).contains(c));
    usable.then(|| colour.map(f32::ln))
}

fn overlap(a: usize, b: usize, ratios: &[[f64; 3]]) -> Option<Overlap> {
    if ratios.len() < LEAST_PLACES {
        return None;
    }
    let log_ratio = [0, 1, 2].map(|channel| median(ratios.iter().map(|r| r[channel])));
    let means = || ratios.iter().map(|r| r.iter().sum::<f64>() / 3.0);
    let middle = median(means());
    let deviation = NORMAL_DEVIATION * median(means().map(|mean| (mean - middle).abs()));
    let random = MEDIAN_VARIANCE * deviation.powi(2) / ratios.len() as f64;
    Some(Overlap { a, b, log_ratio, variance: SYSTEMATIC.powi(2) + random })
}

/// The lower one of the two in the middle; 0 of nothing.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let Some(middle) = values.len().checked_sub(1).map(|last| last / 2) else { return 0.0 };
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerances::OVERLAP_LOGARITHM;

    /// Two photographs, the second `ratio` times as bright, with two places out of five wrong.
    fn samples(ratio: f32, places: usize) -> Samples {
        let first: Vec<_> = (0..places)
            .map(|i| Some([0.1, 0.15, 0.2].map(|c| c * (1.0 + (i % 7) as f32 / 7.0))))
            .collect();
        let second = first.iter().enumerate().map(|(i, colour)| {
            let wrong = if i % 5 < 2 { 2.5 } else { 1.0 };
            colour.map(|c: [f32; 3]| c.map(|c| (c * ratio * wrong).min(0.79)))
        });
        let second = second.collect();
        Samples { places_each: places / 2, colours: vec![first, second] }
    }

    #[test]
    fn outliers_do_not_move_the_ratio() {
        let found = overlaps(&samples(0.7, 100));
        let [overlap] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((overlap.a, overlap.b), (0, 1));
        let error = overlap.log_ratio.map(|r| (r - 0.7f64.ln()).abs());
        assert!(error.iter().all(|e| *e < OVERLAP_LOGARITHM), "{error:?}");
    }

    #[test]
    fn what_cannot_be_compared_is_left_out() {
        assert_eq!(overlaps(&samples(0.7, LEAST_PLACES - 2)), []);
        assert_eq!(overlaps(&Samples::default()), []);
        for unusable in [f32::NAN, 0.001, 0.95, f32::INFINITY, -0.2] {
            let mut samples = samples(0.7, 100);
            samples.colours[1].iter_mut().flatten().for_each(|colour| colour[1] = unusable);
            assert_eq!(overlaps(&samples), [], "{unusable}");
        }
    }
}

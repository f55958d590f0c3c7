//! The gains that make overlapping photographs agree, by least squares.
//!
//! With `x_i = ln(gain of photograph i)` and `r_ij = ln(colour in j / colour in i)` the overlaps
//! want `x_i − x_j = r_ij`. Minimised is
//!
//! `Σ_ij (x_i − x_j − r_ij)² / σ_ij² + Σ_i x_i² / σ_0²`
//!
//! once for the mean of the channels, with a σ_0 that lets exposures differ, and once for each
//! channel's deviation from that mean, with a smaller one: cameras differ in exposure more than
//! in colour. The second sum keeps the mean gain of photographs that overlap each other, directly
//! or through others, at 1, as it does that of a photograph that overlaps none.

use super::overlaps::Overlap;

/// Standard deviation expected of the logarithm of exposures.
pub(super) const EXPOSURE_DEVIATION: f64 = 0.3;
/// The same of a channel's deviation from the mean of the three.
pub(super) const COLOUR_DEVIATION: f64 = 0.1;
/// No gain is larger, nor smaller than one over it.
pub(super) const LARGEST_GAIN: f64 = 4.0;

/// The logarithms of the gains of `count` photographs, for linear red, green and blue. Overlaps
/// that are no numbers, or not of two of the photographs, are left out.
pub(crate) fn solve(count: usize, overlaps: &[Overlap]) -> Vec<[f64; 3]> {
    let overlaps: Vec<&Overlap> = overlaps
        .iter()
        .filter(|o| o.a < count && o.b < count && o.a != o.b)
        .filter(|o| o.variance > 0.0 && (o.variance + o.log_ratio.iter().sum::<f64>()).is_finite())
        .collect();
    let mean = |o: &Overlap| o.log_ratio.iter().sum::<f64>() / 3.0;
    let exposures = channel(count, &overlaps, EXPOSURE_DEVIATION, mean);
    let colours = [0, 1, 2]
        .map(|c| channel(count, &overlaps, COLOUR_DEVIATION, |o| o.log_ratio[c] - mean(o)));
    let limit = LARGEST_GAIN.ln();
    (0..count)
        .map(|i| [0, 1, 2].map(|c| (exposures[i] + colours[c][i]).clamp(-limit, limit)))
        .collect()
}

/// The least squares for one number a photograph.
fn channel(
    count: usize,
    overlaps: &[&Overlap],
    deviation: f64,
    ratio: impl Fn(&Overlap) -> f64,
) -> Vec<f64> {
    let mut normal = vec![0.0; count * count];
    let mut right = vec![0.0; count];
    for i in 0..count {
        normal[i * count + i] = deviation.powi(-2);
    }
    for overlap in overlaps {
        let (a, b, weight) = (overlap.a, overlap.b, 1.0 / overlap.variance);
        normal[a * count + a] += weight;
        normal[b * count + b] += weight;
        normal[a * count + b] -= weight;
        normal[b * count + a] -= weight;
        right[a] += weight * ratio(overlap);
        right[b] -= weight * ratio(overlap);
    }
    solve_positive_definite(count, normal, right)
}

/// Solves `A x = b` by Cholesky's factors, `A = L Lᵀ`, in place. `a` is symmetric and positive
/// definite, rows one after the other.
fn solve_positive_definite(count: usize, mut a: Vec<f64>, mut x: Vec<f64>) -> Vec<f64> {
    for column in 0..count {
        for row in column..count {
            let done: f64 = (0..column).map(|k| a[row * count + k] * a[column * count + k]).sum();
            let value = a[row * count + column] - done;
            a[row * count + column] =
                if row == column { value.sqrt() } else { value / a[column * count + column] };
        }
    }
    for row in 0..count {
        let done: f64 = (0..row).map(|k| a[row * count + k] * x[k]).sum();
        x[row] = (x[row] - done) / a[row * count + row];
    }
    for row in (0..count).rev() {
        let done: f64 = (row + 1..count).map(|k| a[k * count + row] * x[k]).sum();
        x[row] = (x[row] - done) / a[row * count + row];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerances::GAIN_SHRINKAGE;

    /// Overlaps of photographs whose exposures differ by known gains, with their mean at 1.
    fn overlaps_of(gains: &[[f64; 3]], pairs: &[(usize, usize)]) -> Vec<Overlap> {
        let overlap = |&(a, b): &(usize, usize)| {
            let log_ratio = [0, 1, 2].map(|c| gains[a][c] - gains[b][c]);
            Overlap { a, b, log_ratio, variance: 1e-3 }
        };
        pairs.iter().map(overlap).collect()
    }

    #[test]
    fn known_gains_are_recovered() {
        let count = 9;
        let mut gains: Vec<[f64; 3]> = (0..count)
            .map(|i| {
                let exposure = 0.5 * (f64::from(i) * 2.3).sin();
                let tint = 0.1 * (f64::from(i) * 1.1).cos();
                [exposure + tint, exposure, exposure - tint]
            })
            .collect();
        for channel in 0..3 {
            let mean = gains.iter().map(|g| g[channel]).sum::<f64>() / gains.len() as f64;
            gains.iter_mut().for_each(|g| g[channel] -= mean);
        }
        // A street: each overlaps the next two.
        let pairs: Vec<(usize, usize)> =
            (0..8).map(|i| (i, i + 1)).chain((0..7).map(|i| (i + 2, i))).collect();
        let found = solve(gains.len(), &overlaps_of(&gains, &pairs));
        for (found, truth) in found.iter().zip(&gains) {
            for (found, truth) in found.iter().zip(truth) {
                assert!((found - truth).abs() < GAIN_SHRINKAGE, "{found} for {truth}");
            }
        }
    }

    #[test]
    fn photographs_that_do_not_overlap_keep_their_own_mean() {
        assert_eq!(solve(0, &[]), Vec::<[f64; 3]>::new());
        assert_eq!(solve(1, &[]), [[0.0; 3]]);
        // Two pairs that know nothing of each other, and one photograph alone.
        let gains = [[0.4; 3], [-0.4; 3], [-0.1; 3], [0.1; 3], [0.0; 3]];
        let found = solve(5, &overlaps_of(&gains, &[(0, 1), (2, 3)]));
        for (found, truth) in found.iter().zip(&gains) {
            assert!((found[0] - truth[0]).abs() < GAIN_SHRINKAGE, "{found:?} for {truth:?}");
        }
        assert_eq!(found[4], [0.0; 3]);
    }

    #[test]
    fn nonsense_is_left_out_and_gains_are_bounded() {
        let gains = [[0.2; 3], [-0.2; 3]];
        let good = overlaps_of(&gains, &[(0, 1)]);
        let expected = solve(2, &good);
        let Overlap { a, b, log_ratio, variance } = good[0];
        let nonsense = [
            Overlap { a, b, log_ratio: [f64::NAN, 0.0, 0.0], variance },
            Overlap { a, b, log_ratio: [0.0, f64::INFINITY, 0.0], variance },
            Overlap { a, b, log_ratio, variance: 0.0 },
            Overlap { a, b, log_ratio, variance: f64::NAN },
            Overlap { a, b: a, log_ratio, variance },
            Overlap { a, b: 7, log_ratio, variance },
        ];
        assert_eq!(solve(2, &[&good[..], &nonsense[..]].concat()), expected);
        let extreme = solve(2, &overlaps_of(&[[40.0; 3], [-40.0; 3]], &[(0, 1)]));
        assert_eq!(extreme, [[LARGEST_GAIN.ln(); 3], [-LARGEST_GAIN.ln(); 3]]);
    }
}

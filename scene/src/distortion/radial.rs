//! The odd polynomial `r (1 + k₀ r² + k₁ r⁴ + …)`: where it grows, and its inverse there.

/// The most coefficients that a model has.
const MAX_TERMS: usize = 4;

/// `1 + k₀ r² + k₁ r⁴ + …`, by Horner's rule.
pub(super) fn scale(k: &[f64], r2: f64) -> f64 {
    1.0 + k.iter().rev().fold(0.0, |sum, &c| (sum + c) * r2)
}

/// Whether `r (1 + k₀ r² + …)` grows on all of [0, r]; false for NaN.
///
/// Its derivative is a polynomial in s = r², `1 + 3 k₀ s + 5 k₁ s² + …`, that must be positive
/// on [0, r²]. It lies between the least and the greatest of its Bernstein coefficients there,
/// so positive ones decide; else the interval is split. A handful of operations for any lens
/// inside its image, where finding the root takes a few hundred.
pub(super) fn grows_until(k: &[f64], r: f64) -> bool {
    let mut monomial = [0.0; MAX_TERMS + 1];
    monomial[0] = 1.0;
    let mut power = 1.0;
    for (i, (c, m)) in k.iter().zip(&mut monomial[1..]).enumerate() {
        power *= r * r;
        *m = c * (2 * i + 3) as f64 * power;
    }
    // b_j = Σ_{i ≤ j} C(j, i) / C(4, i) m_i.
    let [m0, m1, m2, m3, m4] = monomial;
    is_positive([
        m0,
        m0 + m1 / 4.0,
        m0 + m1 / 2.0 + m2 / 6.0,
        m0 + m1 * 0.75 + m2 / 2.0 + m3 / 4.0,
        m0 + m1 + m2 + m3 + m4,
    ])
}

/// Whether the quartic with these Bernstein coefficients is positive on its interval.
fn is_positive(b: [f64; 5]) -> bool {
    // Halving f64 this often leaves one number; only a polynomial that touches zero without
    // crossing it gets so far.
    fn split(b: [f64; 5], depth: u32) -> bool {
        if !(b[0] > 0.0 && b[4] > 0.0) || depth == 60 {
            return false;
        }
        if b.iter().all(|&c| c > 0.0) {
            return true;
        }
        // De Casteljau: the first and last of each row of means bound the halves.
        let (mut row, mut low, mut high) = (b, b, b);
        for i in 1..5 {
            for j in 0..5 - i {
                row[j] = row[j].midpoint(row[j + 1]);
            }
            low[i] = row[0];
            high[4 - i] = row[4 - i];
        }
        split(low, depth + 1) && split(high, depth + 1)
    }
    split(b, 0)
}

/// The smallest r > 0 where `r (1 + k₀ r² + …)` stops growing; infinite if it never does.
///
/// The first positive root of its derivative (see [`grows_until`]) is bracketed between the
/// stationary points found recursively, so that none is stepped over.
pub(super) fn first_turning_point(k: &[f64]) -> f64 {
    let mut coefficients = vec![1.0];
    coefficients.extend(k.iter().zip(1..).map(|(c, i)| c * f64::from(2 * i + 1)));
    positive_roots(&coefficients).first().map_or(f64::INFINITY, |s| s.sqrt())
}

/// All positive roots of `c₀ + c₁ s + …`, ascending, each to full precision by bisection
/// between consecutive stationary points.
fn positive_roots(c: &[f64]) -> Vec<f64> {
    let Some(degree) = c.iter().rposition(|&x| x != 0.0) else { return Vec::new() };
    if degree == 0 || c.iter().any(|x| !x.is_finite()) {
        return Vec::new();
    }
    let c = &c[..=degree];
    let evaluate = |s: f64| c.iter().rev().fold(0.0, |sum: f64, &x| sum.mul_add(s, x));
    let derivative: Vec<f64> = c[1..].iter().zip(1..).map(|(x, i)| x * f64::from(i)).collect();
    // Cauchy's bound: every root lies within it.
    let bound = 1.0 + c[..degree].iter().map(|x| (x / c[degree]).abs()).fold(0.0, f64::max);
    let mut edges = vec![0.0];
    edges.extend(positive_roots(&derivative).into_iter().filter(|&s| s < bound));
    edges.push(bound);
    let mut roots = Vec::new();
    for pair in edges.windows(2) {
        let (mut low, mut high) = (pair[0], pair[1]);
        let sign = evaluate(low) > 0.0;
        if sign == (evaluate(high) > 0.0) {
            continue;
        }
        for _ in 0..2000 {
            let middle = low.midpoint(high);
            if middle <= low || middle >= high {
                break;
            }
            if (evaluate(middle) > 0.0) == sign { low = middle } else { high = middle }
        }
        if low > 0.0 {
            roots.push(low);
        }
    }
    roots
}

/// `r / q` where `r (1 + k₀ r² + …) = q`, `r < ceiling`, and the polynomial grows up to r;
/// `None` where there is no such r.
pub(super) fn inverse_scale(k: &[f64], q: f64, ceiling: f64) -> Option<f64> {
    if q == 0.0 {
        return Some(1.0);
    }
    // Where it grows it takes a value once: what Newton finds there is the solution.
    let quick = newton(k, q).filter(|&r| r < ceiling && grows_until(k, r));
    let r = match quick {
        Some(r) => r,
        None => bisect(k, q, ceiling.min(first_turning_point(k)))?,
    };
    Some(r / q)
}

/// A solution of `r (1 + k₀ r² + …) = q` near q, if Newton finds one; not to be trusted.
fn newton(k: &[f64], q: f64) -> Option<f64> {
    let mut r = q;
    for _ in 0..20 {
        let step = (r * scale(k, r * r) - q) / slope(k, r);
        r -= step;
        if !(r > 0.0) {
            return None;
        }
        if step.abs() <= 2.0 * f64::EPSILON * r {
            return Some(r);
        }
    }
    None
}

/// The solution of `r (1 + k₀ r² + …) = q` below the limit up to which the polynomial grows.
/// Bisection safeguards Newton.
fn bisect(k: &[f64], q: f64, limit: f64) -> Option<f64> {
    let forward = |r: f64| r * scale(k, r * r);
    let mut high = if limit.is_finite() { limit } else { q.max(1e-300) };
    if limit.is_finite() {
        if forward(high) <= q {
            return None;
        }
    } else {
        while forward(high) < q {
            high *= 2.0;
            if !high.is_finite() {
                return None;
            }
        }
    }
    let (mut low, mut r) = (0.0, q.min(high));
    for _ in 0..200 {
        let error = forward(r) - q;
        if error > 0.0 {
            high = r;
        } else {
            low = r;
        }
        if error.abs() <= 1e-15 * q || high - low <= f64::EPSILON * high {
            break;
        }
        let next = r - error / slope(k, r);
        r = if next > low && next < high { next } else { low.midpoint(high) };
    }
    Some(r)
}

/// Derivative of `r (1 + k₀ r² + …)`.
fn slope(k: &[f64], r: f64) -> f64 {
    let terms = k.iter().enumerate().rev();
    1.0 + terms.fold(0.0, |sum, (i, &c)| (sum + c * (2 * i + 3) as f64) * (r * r))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The quick test and the root agree, but for a band of rounding around the root.
        #[test]
        fn growth_ends_at_the_turning_point(
            k in prop::collection::vec(-2.0..2.0, 1..=4), r in 0.0..3.0,
        ) {
            let (r, turn): (f64, f64) = (r, first_turning_point(&k));
            if (r - turn).abs() > 1e-6 * turn {
                prop_assert_eq!(grows_until(&k, r), r < turn, "{} {}", r, turn);
            }
        }

        /// Polynomials with a double or nearly double stationary point, (s − a)² + e in s = r²:
        /// an end of the picture's growth that is easily stepped over.
        #[test]
        fn near_double_turning_points(a in 0.1..2.0_f64, e in -1e-3..1e-3_f64, r in 0.0..3.0_f64) {
            // 1 + 3 k₀ s + 5 k₁ s² = ((s − a)² + e) / (a² + e).
            let scale = a * a + e;
            let k = [-2.0 * a / scale / 3.0, 1.0 / scale / 5.0];
            let turn = if e < 0.0 { (a - (-e).sqrt()).sqrt() } else { f64::INFINITY };
            prop_assume!(e.abs() > 1e-9 && (r - turn).abs() > 1e-6);
            prop_assert_eq!(grows_until(&k, r), r < turn);
            let found = first_turning_point(&k);
            prop_assert!(found == turn || (found - turn).abs() < 1e-6, "{} {}", found, turn);
        }

        #[test]
        fn inverse_is_found_exactly_where_the_polynomial_grows(
            k in prop::collection::vec(-1.0..1.0, 1..=4), r in 1e-6_f64..3.0,
        ) {
            let turn = first_turning_point(&k);
            let q: f64 = r * scale(&k, r * r);
            if r < 0.999 * turn {
                let found = q * inverse_scale(&k, q, f64::INFINITY).expect("it grows up to r");
                // The slope, and with it the accuracy, goes to zero at the turning point.
                let tolerance = 1e-13 * (1.0 + r / slope(&k, r)) * (1.0 + r);
                prop_assert!((found - r).abs() <= tolerance, "{} {}", found, r);
                prop_assert!(inverse_scale(&k, q, 0.999 * r).is_none());
            } else if turn.is_finite() && q > 1.001 * turn * scale(&k, turn * turn) {
                // Only what comes back beyond the fold maps there.
                prop_assert!(inverse_scale(&k, q, f64::INFINITY).is_none());
            }
        }
    }

    #[test]
    fn nothing_grows_until_nan() {
        assert!(!grows_until(&[0.1, 0.2], f64::NAN));
        assert!(!grows_until(&[f64::NAN], 1.0));
        assert!(!grows_until(&[f64::NEG_INFINITY], 1.0));
        assert!(grows_until(&[], 1e100));
    }
}

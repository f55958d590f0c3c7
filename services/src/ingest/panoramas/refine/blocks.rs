//! Symmetric systems of 6×6 blocks, most of which are empty.

use std::collections::HashMap;

/// Six numbers.
pub(super) type Six = [f64; 6];
/// Six rows of six.
pub(super) type Block = [Six; 6];

/// Steps of the method in which it ends at the latest.
const MOST_STEPS: usize = 1000;
/// Residuals are made so small, relative to the right side.
const RELATIVE: f64 = 1e-10;

/// A symmetric matrix that is positive definite: the blocks on its diagonal, and those above it.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    pub(super) diagonal: Vec<Block>,
    /// By row and column; the row is less.
    pub(super) above: HashMap<(usize, usize), Block>,
}

impl Blocks {
    /// Nothing, of `size` blocks a side.
    pub(super) fn zero(size: usize) -> Self {
        Self { diagonal: vec![[[0.0; 6]; 6]; size], above: HashMap::new() }
    }

    /// Solves `self x = right` by conjugate gradients, preconditioned by the inverses of the
    /// blocks on the diagonal (Hestenes and Stiefel, 1952); `None` where one of these is not positive
    /// definite.
    pub(super) fn solve(&self, right: &[Six]) -> Option<Vec<Six>> {
        let factors: Vec<Block> = self.diagonal.iter().map(cholesky).collect::<Option<_>>()?;
        let mut rows: Vec<(&(usize, usize), &Block)> = self.above.iter().collect();
        rows.sort_unstable_by_key(|(key, _)| **key);
        let precondition = |r: &[Six]| -> Vec<Six> {
            factors.iter().zip(r).map(|(factor, r)| substitute(factor, r)).collect()
        };
        let mut x = vec![[0.0; 6]; right.len()];
        let mut residual = right.to_vec();
        let mut z = precondition(&residual);
        let mut direction = z.clone();
        let mut rz = dot(&residual, &z);
        let enough = RELATIVE * RELATIVE * dot(right, right);
        for _ in 0..MOST_STEPS {
            if dot(&residual, &residual) <= enough {
                break;
            }
            let image = self.times(&rows, &direction);
            let step = rz / dot(&direction, &image);
            if !step.is_finite() {
                break;
            }
            add(&mut x, step, &direction);
            add(&mut residual, -step, &image);
            z = precondition(&residual);
            let next = dot(&residual, &z);
            let share = next / rz;
            rz = next;
            for (d, z) in direction.iter_mut().zip(&z) {
                (0..6).for_each(|i| d[i] = z[i] + share * d[i]);
            }
        }
        Some(x)
    }

    fn times(&self, rows: &[(&(usize, usize), &Block)], x: &[Six]) -> Vec<Six> {
        let mut out: Vec<Six> =
            self.diagonal.iter().zip(x).map(|(block, x)| block.map(|row| dot6(&row, x))).collect();
        for ((row, column), block) in rows {
            for i in 0..6 {
                out[*row][i] += dot6(&block[i], &x[*column]);
                for j in 0..6 {
                    out[*column][j] += block[i][j] * x[*row][i];
                }
            }
        }
        out
    }
}

fn dot6(a: &Six, b: &Six) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn dot(a: &[Six], b: &[Six]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot6(a, b)).sum()
}

fn add(to: &mut [Six], times: f64, what: &[Six]) {
    for (to, what) in to.iter_mut().zip(what) {
        (0..6).for_each(|i| to[i] += times * what[i]);
    }
}

/// L with `L Lᵀ = block`, below and on the diagonal.
fn cholesky(block: &Block) -> Option<Block> {
    let mut factor = [[0.0; 6]; 6];
    for i in 0..6 {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let rest = block[i][j] - known;
            factor[i][j] = if i == j {
                // Written so that NaN is refused.
                if !(rest > 0.0) {
                    return None;
                }
                rest.sqrt()
            } else {
                rest / factor[j][j]
            };
        }
    }
    Some(factor)
}

/// x with `L Lᵀ x = right`.
fn substitute(factor: &Block, right: &Six) -> Six {
    let mut x = *right;
    for i in 0..6 {
        let known: f64 = (0..i).map(|k| factor[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / factor[i][i];
    }
    for i in (0..6).rev() {
        let known: f64 = (i + 1..6).map(|k| factor[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / factor[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of blocks, each coupled with the next two, against what it is multiplied from.
    #[test]
    fn a_sparse_system_is_solved() {
        let mut state = 7u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let size = 40;
        let mut blocks = Blocks::zero(size);
        for i in 0..size {
            for j in i + 1..(i + 3).min(size) {
                blocks
                    .above
                    .insert((i, j), std::array::from_fn(|_| std::array::from_fn(|_| next())));
            }
            for k in 0..6 {
                blocks.diagonal[i][k][k] = 14.0 + next();
            }
        }
        let wanted: Vec<Six> = (0..size).map(|_| std::array::from_fn(|_| next())).collect();
        let mut right = vec![[0.0; 6]; size];
        for i in 0..size {
            for k in 0..6 {
                right[i][k] += blocks.diagonal[i][k][k] * wanted[i][k];
            }
        }
        for ((i, j), block) in &blocks.above {
            for k in 0..6 {
                for l in 0..6 {
                    right[*i][k] += block[k][l] * wanted[*j][l];
                    right[*j][l] += block[k][l] * wanted[*i][k];
                }
            }
        }
        let found = blocks.solve(&right).expect("positive definite");
        for (found, wanted) in found.iter().flatten().zip(wanted.iter().flatten()) {
            assert!((found - wanted).abs() < 1e-8, "{found} instead of {wanted}");
        }
        blocks.diagonal[3][2][2] = -1.0;
        assert_eq!(blocks.solve(&right), None);
    }
}

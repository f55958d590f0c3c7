//! How costs grow with what is drawn.

use serde::Serialize;

use super::Inputs;

/// What a pass took for so much of what it works on.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Cost {
    /// What was set.
    pub(crate) setting: String,
    /// How much was drawn.
    pub(crate) amount: f64,
    /// Median time of the pass, milliseconds.
    pub(crate) ms: f64,
}

/// The same views with more resident that they do not see.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct OffScreen {
    /// What was resident besides.
    pub(crate) resident: &'static str,
    /// What was resident in all, and drawn.
    #[serde(flatten)]
    pub(crate) inputs: Inputs,
    /// Median time of the frame, milliseconds.
    pub(crate) ms: f64,
}

/// The line that is nearest to the costs by least squares: milliseconds at nothing, milliseconds
/// each, and the share of the variance that it explains. `None` for fewer than two amounts.
pub(crate) fn line_through(costs: &[Cost]) -> Option<[f64; 3]> {
    let n = costs.len() as f64;
    let mean = |of: fn(&Cost) -> f64| costs.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|c| c.amount), mean(|c| c.ms));
    let sum = |of: &dyn Fn(&Cost) -> f64| costs.iter().map(of).sum::<f64>();
    let xx = sum(&|c| (c.amount - x).powi(2));
    let xy = sum(&|c| (c.amount - x) * (c.ms - y));
    let yy = sum(&|c| (c.ms - y).powi(2));
    if !(xx > 0.0) {
        return None;
    }
    let each = xy / xx;
    let explained = if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 };
    Some([y - each * x, each, explained])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(pairs: &[(f64, f64)]) -> Vec<Cost> {
        let cost = |&(amount, ms)| Cost { setting: String::new(), amount, ms };
        pairs.iter().map(cost).collect()
    }

    #[test]
    fn a_line_is_found() {
        let exact = costs(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]);
        let [at_nothing, each, explained] = line_through(&exact).expect("a line");
        assert!((at_nothing - 3.0).abs() < 1e-12 && (each - 2.0).abs() < 1e-12);
        assert!((explained - 1.0).abs() < 1e-12);
        let bent = costs(&[(1.0, 1.0), (2.0, 4.0), (3.0, 9.0), (4.0, 16.0), (5.0, 25.0)]);
        assert!(line_through(&bent).is_some_and(|[.., explained]| explained < 0.97));
        assert!(line_through(&costs(&[(2.0, 1.0), (2.0, 3.0)])).is_none());
        assert!(line_through(&[]).is_none());
    }
}

//! Which settings nothing beats.

/// Whether each of `costs`, as time and error, is on the front: no other one is at least as good
/// in both and better in one. Figures that are no numbers are not on it.
pub(crate) fn mark_front(costs: &[[f64; 2]]) -> Vec<bool> {
    let beats = |a: &[f64; 2], b: &[f64; 2]| a[0] <= b[0] && a[1] <= b[1] && a != b;
    costs
        .iter()
        .map(|cost| {
            cost.iter().all(|figure| figure.is_finite())
                && !costs.iter().any(|other| beats(other, cost))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_beats_is_not_on_the_front() {
        let costs = [[10.0, 5.0], [20.0, 1.0], [20.0, 2.0], [30.0, 1.0], [5.0, 50.0], [6.0, 50.0]];
        assert_eq!(mark_front(&costs), [true, true, false, false, true, false]);
        assert_eq!(mark_front(&[[1.0, 1.0], [1.0, 1.0]]), [true, true], "equals do not beat");
        assert_eq!(mark_front(&[[f64::NAN, 0.0], [3.0, f64::INFINITY]]), [false, false]);
        assert!(mark_front(&[]).is_empty());
    }
}

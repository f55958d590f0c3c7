//! Which frames may be on the front: a way from the most exact settings down to the cheapest.
//!
//! All combinations of all values are too many to measure. What each value alone saves and spoils is
//! known from the sweep, and nearly independent of the others: the way goes down by whatever saves
//! most time for the error that it adds. What it passes is then measured.

use flaneur_renderer::Settings;

/// Values of each setting, the most exact first.
pub(crate) const RIGS: [usize; 8] = [16, 12, 8, 6, 4, 3, 2, 1];
/// Shares of the points that a view meets.
pub(crate) const POINTS: [f32; 5] = [1.0, 0.75, 0.5, 0.25, 0.125];
/// Depths tried where nothing is known; `None`: such pixels stay empty.
pub(crate) const HYPOTHESES: [Option<u32>; 7] =
    [Some(31), Some(15), Some(7), Some(3), Some(1), Some(0), None];
/// Whether photographs are aligned.
pub(crate) const ALIGN: [bool; 2] = [true, false];
/// Share of the picture's sides.
pub(crate) const RESOLUTIONS: [f32; 8] = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.42, 0.35];

/// More than this share of the pixels left without colour is no picture.
pub(crate) const MOST_UNCOVERED: f64 = 0.01;
/// Least logarithm of a factor of time that a step is taken for.
const WORTH: f64 = 0.01;

/// Indices of one value of each setting, in the order in which they stand above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Rung(pub(crate) [usize; 5]);

/// What a value of a setting alone costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Single {
    /// Median time of a frame, milliseconds.
    pub(crate) ms: f64,
    /// Mean squared error against the most exact frame.
    pub(crate) mse: f64,
    /// Share of the pixels that it leaves without colour.
    pub(crate) uncovered: f64,
}

/// What each value of each setting costs, all others being the most exact.
pub(crate) type Sweep = [Vec<Single>; 5];

impl Rung {
    /// Its settings, from those that are the most exact.
    pub(crate) fn settings(self, exact: Settings) -> Settings {
        let [rigs, points, hypotheses, align, resolution] = self.0;
        let hypotheses = HYPOTHESES[hypotheses];
        Settings {
            rigs: RIGS[rigs],
            points_share: POINTS[points],
            infer: hypotheses.is_some(),
            inferred_hypotheses: hypotheses.unwrap_or(exact.inferred_hypotheses),
            align: ALIGN[align],
            resolution: RESOLUTIONS[resolution],
            ..exact
        }
    }
}

/// The way from the most exact rung, which is the first, to one from which nothing is worth a step.
/// No value is on it that alone leaves more than [`MOST_UNCOVERED`] without colour.
///
/// Times are taken as products and squared errors as sums of what each setting does alone. Where it
/// goes over several values of a setting at once, those between are on the way, too.
pub(crate) fn way_down(sweep: &Sweep) -> Vec<Rung> {
    let mut way = vec![Rung::default()];
    while let Some((setting, index)) = way.last().and_then(|rung| step(sweep, *rung)) {
        let mut rung = way.last().copied().unwrap_or_default();
        while rung.0[setting] < index {
            rung.0[setting] += 1;
            way.push(rung);
        }
    }
    way
}

/// The setting that changes next, and the index of its value.
fn step(sweep: &Sweep, from: Rung) -> Option<(usize, usize)> {
    let mut best: Option<(f64, (usize, usize))> = None;
    for (setting, values) in sweep.iter().enumerate() {
        let Some(now) = values.get(from.0[setting]) else { continue };
        for (index, then) in values.iter().enumerate().skip(from.0[setting] + 1) {
            let saved = (now.ms / then.ms).ln();
            // Noise may make a cheaper value look nearer.
            let spoilt = (then.mse - now.mse).max(1e-3);
            let shows_all = then.uncovered <= MOST_UNCOVERED;
            if shows_all && saved >= WORTH && best.is_none_or(|(worth, _)| saved / spoilt > worth) {
                best = Some((saved / spoilt, (setting, index)));
            }
        }
    }
    best.map(|(_, step)| step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(ms: f64, mse: f64) -> Single {
        Single { ms, mse, uncovered: if mse > 1e3 { 0.5 } else { 0.0 } }
    }

    #[test]
    fn what_spoils_least_for_its_time_goes_first() {
        let none = || vec![single(100.0, 0.0)];
        let sweep: Sweep = [
            // The middle value costs more and spoils more than the last: it is no aim of a step.
            vec![single(100.0, 0.0), single(101.0, 50.0), single(50.0, 10.0)],
            none(),
            // Saves nothing.
            vec![single(100.0, 0.0), single(99.9, 0.0)],
            vec![single(100.0, 0.0), single(80.0, 1.0)],
            vec![single(100.0, 0.0), single(70.0, 90.0), single(40.0, 300.0), single(9.0, 2e3)],
        ];
        let way: Vec<[usize; 5]> = way_down(&sweep).into_iter().map(|rung| rung.0).collect();
        let expected = [
            [0; 5],
            [0, 0, 0, 1, 0],
            [1, 0, 0, 1, 0],
            [2, 0, 0, 1, 0],
            [2, 0, 0, 1, 1],
            [2, 0, 0, 1, 2],
        ];
        assert_eq!(way, expected);
    }

    #[test]
    fn rungs_are_settings() {
        let exact = Settings::default();
        let settings = Rung([2, 3, 6, 1, 4]).settings(exact);
        assert_eq!((settings.rigs, settings.points_share, settings.infer), (8, 0.25, false));
        assert_eq!((settings.align, settings.resolution), (false, 0.6));
        assert_eq!(Rung::default().settings(exact).points_share, 1.0);
    }
}

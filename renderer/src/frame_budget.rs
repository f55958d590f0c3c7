//! Settings that hold the time of a frame.
//!
//! The settings that trade time for error are gone through on one ladder, from the most exact
//! downwards, each rung a little cheaper than the one above. Nothing is assumed of the machine:
//! frames are timed, and the rung follows. A change needs several frames that agree, so that one
//! that is late moves nothing; it goes as far down as the rungs' costs suggest and up with care, and
//! not soon again to a rung that proved too slow. Between 0.85 and 1.1 times the budget nothing
//! changes: rungs differ by less than that, so that a rung is found where the machine has one.

use std::time::Duration;

use crate::Settings;

/// Above this share of the budget frames are made cheaper …
const HIGH: f64 = 1.1;
/// … and below this more exact.
const LOW: f64 = 0.85;
/// What is aimed at when something changes.
const AIM: f64 = 0.95;
/// Frames of one rung that are judged together, by their median.
const WINDOW: usize = 3;
/// Frames after a change that do not count: buffers may be made anew.
const UNSETTLED: usize = 1;
/// How many judgements a rung that proved too slow is not tried again …
const AVOIDED: u32 = 300;
/// … unless frames take less than this share of what they took on the same rung after it: what
/// is seen has changed.
const EASIER: f64 = 0.6;

/// Chooses settings so that frames take a given time.
///
/// Not used, nothing depends on time: the same scene and view give the same picture.
#[derive(Clone, Debug)]
pub struct FrameBudget {
    budget: Duration,
    rung: usize,
    times: Vec<Duration>,
    to_ignore: usize,
    ceiling: Option<Ceiling>,
    /// Whether the last change was upwards.
    went_up: bool,
    judged: bool,
}

/// The rung above which nothing is tried.
#[derive(Clone, Copy, Debug)]
struct Ceiling {
    rung: usize,
    /// For so many judgements more.
    left: u32,
    /// What frames took when the rung in use was first judged, as a share of the budget.
    share: Option<f64>,
}

impl Ceiling {
    /// After one more judgement; `None` where it holds no longer.
    fn judged(self, share: f64) -> Option<Self> {
        let first = self.share.unwrap_or(share);
        let left = self.left.checked_sub(1)?;
        (share >= EASIER * first).then_some(Self { left, share: Some(first), ..self })
    }
}

/// One rung: the most that is spent on each kind of exactness, and what a frame costs about, as a
/// share of the first rung's.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rung {
    rigs: usize,
    points: u64,
    hypotheses: u32,
    resolution: f32,
    cost: f64,
}

const fn rung(rigs: usize, points: u64, hypotheses: u32, resolution: f32, cost: f64) -> Rung {
    Rung { rigs, points, hypotheses, resolution, cost }
}

const ALL: u64 = u64::MAX;

/// Photographs first, which cost most and show least; then points, coarser ones in their place;
/// sharpness last.
const LADDER: [Rung; 24] = [
    rung(16, ALL, 31, 1.0, 1.0),
    rung(14, ALL, 23, 1.0, 0.93),
    rung(12, ALL, 15, 1.0, 0.86),
    rung(10, ALL, 11, 1.0, 0.79),
    rung(8, ALL, 7, 1.0, 0.71),
    rung(7, 4_000_000, 7, 1.0, 0.65),
    rung(6, 3_000_000, 5, 1.0, 0.59),
    rung(5, 2_000_000, 5, 1.0, 0.53),
    rung(4, 2_000_000, 3, 1.0, 0.47),
    rung(4, 1_400_000, 3, 0.95, 0.43),
    rung(3, 1_400_000, 3, 0.95, 0.39),
    rung(3, 1_000_000, 3, 0.9, 0.35),
    rung(3, 700_000, 1, 0.85, 0.315),
    rung(2, 700_000, 1, 0.85, 0.28),
    rung(2, 500_000, 1, 0.8, 0.25),
    rung(2, 350_000, 1, 0.74, 0.222),
    rung(2, 350_000, 1, 0.68, 0.2),
    rung(2, 250_000, 1, 0.62, 0.178),
    rung(2, 250_000, 1, 0.57, 0.16),
    rung(2, 180_000, 1, 0.52, 0.143),
    rung(1, 180_000, 1, 0.52, 0.126),
    rung(1, 120_000, 1, 0.47, 0.112),
    rung(1, 120_000, 1, 0.42, 0.1),
    rung(1, 80_000, 1, 0.38, 0.09),
];

impl FrameBudget {
    /// Frames of about `budget`, at first of a middling exactness.
    pub fn new(budget: Duration) -> Self {
        Self {
            budget,
            rung: LADDER.len() / 3,
            times: Vec::with_capacity(WINDOW),
            to_ignore: UNSETTLED,
            ceiling: None,
            went_up: false,
            judged: false,
        }
    }

    /// The settings of `base`, as exact as any rung is where rungs differ.
    pub fn most_exact(base: Settings) -> Settings {
        let Rung { rigs, points, hypotheses, resolution, .. } = LADDER[0];
        let inferred_hypotheses = hypotheses;
        Settings { rigs, frame_points: points, inferred_hypotheses, resolution, ..base }
    }

    /// What the next frame is to be rendered with: nowhere more exact than `base`.
    pub fn settings(&self, base: Settings) -> Settings {
        let Some(rung) = LADDER.get(self.rung) else { return base };
        Settings {
            rigs: base.rigs.min(rung.rigs),
            frame_points: base.frame_points.min(rung.points),
            inferred_hypotheses: base.inferred_hypotheses.min(rung.hypotheses),
            resolution: base.resolution.min(rung.resolution),
            ..base
        }
    }

    /// Takes note of how long a frame took that was rendered with the settings given last;
    /// whether those change.
    pub fn observe(&mut self, time: Duration) -> bool {
        if self.to_ignore > 0 {
            self.to_ignore -= 1;
            return false;
        }
        self.times.push(time);
        if self.times.len() < WINDOW {
            return false;
        }
        let share = self.median_share();
        self.judged = true;
        self.ceiling = self.ceiling.and_then(|ceiling| ceiling.judged(share));
        let to = if share > HIGH {
            self.cheaper(share)
        } else if share < LOW {
            self.more_exact(share)
        } else {
            self.rung
        };
        if to == self.rung {
            self.times.remove(0);
            return false;
        }
        if to > self.rung && self.went_up {
            self.ceiling = Some(Ceiling { rung: self.rung + 1, left: AVOIDED, share: None });
        } else if let Some(ceiling) = &mut self.ceiling {
            ceiling.share = None;
        }
        self.went_up = to < self.rung;
        self.rung = to;
        self.times.clear();
        self.to_ignore = UNSETTLED;
        self.judged = false;
        true
    }

    /// Whether the last frames were judged and nothing was to be changed: the budget is held, or
    /// there is no more exact rung, or no cheaper one.
    pub fn is_settled(&self) -> bool {
        self.judged
    }

    /// Where on the ladder the settings stand: 0 the most exact, 1 the cheapest.
    pub fn haste(&self) -> f64 {
        self.rung as f64 / (LADDER.len() - 1) as f64
    }

    /// The median of the last times, as a share of the budget.
    fn median_share(&self) -> f64 {
        let mut sorted = self.times.clone();
        sorted.sort_unstable();
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or_default();
        median.as_secs_f64() / self.budget.as_secs_f64().max(1e-6)
    }

    /// The first rung below that should fit, the last where none does.
    fn cheaper(&self, share: f64) -> usize {
        let cost = self.cost() * AIM / share;
        let below = LADDER.iter().enumerate().skip(self.rung + 1);
        let last = LADDER.len() - 1;
        below.into_iter().find(|(_, rung)| rung.cost <= cost).map_or(last, |(index, _)| index)
    }

    /// The most exact rung that should fit, this one where none above does. Half the way there, so
    /// that a rung which costs more than it should is not overshot by much.
    fn more_exact(&self, share: f64) -> usize {
        let cost = self.cost() * AIM / share;
        let ceiling = self.ceiling.map_or(0, |ceiling| ceiling.rung);
        let mut above = (ceiling..self.rung).filter(|&index| LADDER[index].cost <= cost);
        let found = above.next().unwrap_or(self.rung);
        found + (self.rung - found) / 2
    }

    fn cost(&self) -> f64 {
        LADDER.get(self.rung).map_or(1.0, |rung| rung.cost)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A machine that takes this long, in milliseconds, for what it is told to do: a part for
    /// each pixel and rig, one for each point, and one for nothing at all.
    struct Machine {
        nothing: f64,
        per_rig: f64,
        per_megapoint: f64,
        megapoints: f64,
    }

    impl Machine {
        fn ms(&self, settings: &Settings) -> f64 {
            let pixels = f64::from(settings.resolution).powi(2);
            let points = (settings.frame_points as f64 / 1e6).min(self.megapoints);
            self.nothing
                + self.per_rig * pixels * (2.0 + settings.rigs as f64)
                + self.per_megapoint * points
        }
    }

    fn finest() -> Settings {
        FrameBudget::most_exact(Settings::default())
    }

    /// The times of `frames` frames, each off by up to `noise` of itself, and how often settings
    /// changed in the second half.
    fn run(
        machine: &Machine,
        budget: &mut FrameBudget,
        frames: usize,
        noise: &[f64],
    ) -> (Vec<f64>, usize) {
        let (mut times, mut changes) = (Vec::new(), 0);
        for frame in 0..frames {
            let ms = machine.ms(&budget.settings(finest()))
                * (1.0 + noise.get(frame % noise.len().max(1)).copied().unwrap_or(0.0));
            times.push(ms);
            let changed = budget.observe(Duration::from_secs_f64(ms / 1e3));
            changes += usize::from(changed && frame >= frames / 2);
        }
        (times, changes)
    }

    #[test]
    fn rungs_are_each_a_little_cheaper() {
        for pair in LADDER.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            assert!(b.cost < a.cost && b.cost > 0.8 * a.cost, "{a:?} {b:?}");
            assert!(b.rigs <= a.rigs && b.points <= a.points, "{a:?} {b:?}");
            assert!(b.resolution <= a.resolution && b.hypotheses <= a.hypotheses);
        }
        assert_eq!(FrameBudget::new(Duration::MAX).settings(finest()).rigs, LADDER[8].rigs);
    }

    #[test]
    fn a_base_is_never_exceeded() {
        let base = Settings { rigs: 2, frame_points: 1000, resolution: 0.5, ..finest() };
        let mut budget = FrameBudget::new(Duration::from_secs(10));
        for _ in 0..60 {
            let settings = budget.settings(base);
            assert!(settings.rigs <= 2 && settings.frame_points <= 1000);
            assert!(settings.resolution <= 0.5);
            budget.observe(Duration::from_millis(1));
        }
        assert_eq!((budget.haste(), budget.is_settled()), (0.0, true));
    }

    #[test]
    fn one_late_frame_moves_nothing() {
        let machine = Machine { nothing: 5.0, per_rig: 8.0, per_megapoint: 20.0, megapoints: 2.0 };
        let mut budget = FrameBudget::new(Duration::from_millis(80));
        run(&machine, &mut budget, 60, &[0.0]);
        let before = budget.settings(finest());
        assert!(!budget.observe(Duration::from_secs(2)));
        run(&machine, &mut budget, 10, &[0.0]);
        assert_eq!(budget.settings(finest()), before);
    }

    /// The street opens, and there is three times as much to see: the budget is held again soon.
    #[test]
    fn a_view_that_moves_is_followed() {
        let mut budget = FrameBudget::new(Duration::from_millis(100));
        for megapoints in [0.5, 4.0, 1.5, 0.2] {
            let machine = Machine { nothing: 10.0, per_rig: 11.0, per_megapoint: 30.0, megapoints };
            let (times, _) = run(&machine, &mut budget, 60, &[0.03, -0.04, 0.0, 0.05]);
            let (settled, late) = (&times[40..], times[20..].iter().filter(|ms| **ms > 120.0));
            assert!(settled.iter().all(|ms| (80.0..=120.0).contains(ms)), "{settled:?}");
            assert_eq!(late.count(), 0, "{megapoints}: {times:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// On any machine whose costs are mostly what settings change, the budget is held within
        /// a fifth where any rung can hold it, and settings come to rest.
        #[test]
        fn the_budget_is_held_without_oscillation(
            nothing in 0.0..5.0f64,
            per_rig in 0.5..20.0f64,
            per_megapoint in 1.0..40.0f64,
            megapoints in 0.1..5.0f64,
            share in 0.0..1.0f64,
            noise in prop::collection::vec(-0.05..0.05f64, 7..23),
        ) {
            let machine = Machine { nothing, per_rig, per_megapoint, megapoints };
            let rung_ms = |index: usize| {
                let budget = FrameBudget { rung: index, ..FrameBudget::new(Duration::MAX) };
                machine.ms(&budget.settings(finest()))
            };
            let (finest_ms, cheapest_ms) = (rung_ms(0), rung_ms(LADDER.len() - 1));
            let target = cheapest_ms * (finest_ms / cheapest_ms).powf(share);
            let mut budget = FrameBudget::new(Duration::from_secs_f64(target / 1e3));
            let (times, changes) = run(&machine, &mut budget, 240, &noise);
            // Where rungs lie closer together than the band, one is always inside.
            let mut last = times[180..].to_vec();
            last.sort_unstable_by(f64::total_cmp);
            let median = last[30] / target;
            let steps = (1..LADDER.len()).map(|index| rung_ms(index - 1) / rung_ms(index));
            let reachable = steps.fold(1.0, f64::max) < 1.29;
            prop_assert!(!reachable || median >= 0.8, "{median}");
            prop_assert!(median <= 1.1 && last[59] <= 1.2 * target, "{median}, {}", last[59] / target);
            prop_assert!(changes <= 4, "{changes} changes");
        }
    }
}

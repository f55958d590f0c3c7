//! Budgets on machines that are equations.

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
        let points = f64::from(settings.points_share) * self.megapoints;
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

/// Whatever bench measures next: a rung below must be cheaper everywhere, and nowhere more exact.
#[test]
fn each_rung_is_cheaper_than_the_one_above() {
    assert!(LADDER.len() >= 6, "{} rungs", LADDER.len());
    for pair in LADDER.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        assert!(b.ms < a.ms && b.ms > 0.0, "{a:?} {b:?}");
        assert!(b.rigs <= a.rigs && b.points <= a.points && b.align <= a.align, "{a:?} {b:?}");
        assert!(b.resolution <= a.resolution && b.hypotheses <= a.hypotheses, "{a:?} {b:?}");
        assert!(b.rigs > 0 && b.resolution >= 0.1, "{b:?}");
    }
}

#[test]
fn the_first_frame_comes_soon_and_the_second_is_of_a_middling_exactness() {
    let mut budget = FrameBudget::new(Duration::MAX);
    let first = budget.settings(finest());
    let cheapest = FRONT.last().expect("measured");
    assert_eq!((first.rigs, first.resolution), (cheapest.rigs, cheapest.resolution));
    assert!(budget.observe(Duration::from_secs(1)), "the settings change");
    assert_eq!(budget.settings(finest()).rigs, LADDER[LADDER.len() / 3].rigs);
    assert_eq!(budget.standing(), None, "nothing was judged");
}

#[test]
fn the_second_frame_is_no_more_exact_than_what_the_budget_allowed_where_the_front_was_measured() {
    for ms in [50, 80, 100, 120] {
        let mut budget = FrameBudget::new(Duration::from_millis(ms));
        budget.observe(Duration::from_secs(1));
        let rung = &LADDER[budget.rung];
        let measured = FRONT.last().expect("measured");
        assert!(rung.ms <= ms as f64 || rung == measured, "{ms}: {rung:?}");
        assert!(rung.ms >= measured.ms && budget.rung >= LADDER.len() / 3, "{ms}: {rung:?}");
    }
    // What nobody measured is not begun with: where it is needed it is found.
    assert_eq!(LADDER[second_rung(Duration::from_millis(1))], *FRONT.last().expect("measured"));
}

#[test]
fn who_comes_later_begins_where_the_last_one_stood() {
    let slow = Machine { nothing: 5.0, per_rig: 20.0, per_megapoint: 1.0, megapoints: 1.0 };
    let mut budget = FrameBudget::new(Duration::from_millis(100));
    run(&slow, &mut budget, 60, &[0.0]);
    let mut next = budget.afresh();
    let (first, cheapest) = (next.settings(finest()), FRONT.last().expect("measured"));
    assert_eq!((first.rigs, first.resolution), (cheapest.rigs, cheapest.resolution));
    next.observe(Duration::from_secs(1));
    assert_eq!(next.settings(finest()), budget.settings(finest()));
    assert_ne!(next.rung, LADDER.len() / 3, "the machine is a slow one");
    assert_eq!(next.standing(), None, "nothing was judged");
}

#[test]
fn a_budget_that_cannot_be_held_is_said() {
    let slow = Machine { nothing: 50.0, per_rig: 20.0, per_megapoint: 1.0, megapoints: 1.0 };
    let mut budget = FrameBudget::new(Duration::from_millis(10));
    assert_eq!(budget.standing(), None, "nothing was judged");
    run(&slow, &mut budget, 60, &[0.0]);
    let standing = budget.standing().expect("judged");
    assert!(!standing.held && standing.rung == standing.rungs - 1, "{standing:?}");
    assert!(standing.reached > Duration::from_millis(50), "{standing:?}");
    let mut budget = FrameBudget::new(Duration::from_secs(10));
    run(&slow, &mut budget, 60, &[0.0]);
    let standing = budget.standing().expect("judged");
    assert!(standing.held && standing.rung == 0, "there is nothing more exact: {standing:?}");
}

#[test]
fn a_base_is_never_exceeded() {
    let base = Settings { rigs: 2, points_share: 0.1, resolution: 0.5, ..finest() };
    let mut budget = FrameBudget::new(Duration::from_secs(10));
    for _ in 0..60 {
        let settings = budget.settings(base);
        assert!(settings.rigs <= 2 && settings.points_share <= 0.1);
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

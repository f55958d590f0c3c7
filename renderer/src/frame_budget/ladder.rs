//! The rungs: the front that was measured, what lies between, and what lies below.

use std::sync::LazyLock;

use super::Rung;
use super::front::FRONT;

/// Rungs take at least this share of the time, the points, the pixels and the rigs of the one above,
/// where settings can be found that lie between: the band in which a budget is held is wider.
const CLOSE: f64 = 0.9;

/// What the points become from one rung to the next below the front, and the sides of the picture …
const FEWER: f32 = 0.8;
const SMALLER: f32 = 0.95;
/// … until so few are left.
const FEWEST: f32 = 0.05;
const SMALLEST: f32 = 0.2;

/// All rungs, the most exact first.
pub(super) static LADDER: LazyLock<Vec<Rung>> = LazyLock::new(|| {
    let mut ladder = between(FRONT);
    below(&mut ladder);
    ladder
});

/// The rungs of `front`, and as many between two of them as it takes for each to be close to the one
/// above, see [`parts`]. What only is or is not cannot be divided: it changes with the lower one.
fn between(front: &[Rung]) -> Vec<Rung> {
    let mut ladder: Vec<Rung> = front.first().copied().into_iter().collect();
    for pair in front.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let parts = parts(&a, &b);
        for part in 1..parts {
            let t = f64::from(part) / f64::from(parts);
            let geometric = |a: f32, b: f32| a * (b / a).powf(t as f32);
            let rung = Rung {
                rigs: (a.rigs as f64 + t * (b.rigs as f64 - a.rigs as f64)).round() as usize,
                points: geometric(a.points, b.points),
                resolution: geometric(a.resolution, b.resolution),
                ms: a.ms * (b.ms / a.ms).powf(t),
                ..a
            };
            let differs = |last: &Rung| Rung { ms: 0.0, ..*last } != Rung { ms: 0.0, ..rung };
            if ladder.last().is_some_and(differs) {
                ladder.push(rung);
            }
        }
        ladder.push(b);
    }
    ladder
}

/// How many steps it takes from one rung to another: neither the time where the front was measured
/// nor any setting that may be what costs most elsewhere changes by much.
fn parts(a: &Rung, b: &Rung) -> u32 {
    let pixels = f64::from(b.resolution / a.resolution).powi(2);
    let rigs = b.rigs as f64 / a.rigs as f64;
    let shares = [b.ms / a.ms, f64::from(b.points / a.points), pixels, rigs];
    let steps = shares.map(|share| (share.ln() / CLOSE.ln()).ceil());
    steps.into_iter().fold(1.0, f64::max) as u32
}

/// Adds rungs for machines on which other things cost most than where the front was measured, and
/// for those that are slower: points and pixels go down together. Photographs stay, for without
/// them there would be holes.
fn below(ladder: &mut Vec<Rung>) {
    let goes_on = |rung: &Rung| rung.points > FEWEST || rung.resolution > SMALLEST;
    while let Some(last) = ladder.last().copied().filter(goes_on) {
        ladder.push(Rung {
            points: (FEWER * last.points).max(FEWEST),
            resolution: (SMALLER * last.resolution).max(SMALLEST),
            ms: CLOSE * last.ms,
            ..last
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::rung;
    use super::*;

    #[test]
    fn below_the_front_there_are_fewer_points_and_pixels() {
        let mut ladder = vec![rung(4, 0.5, Some(3), false, 0.35, 50.0)];
        below(&mut ladder);
        let last = ladder.last().expect("some");
        assert_eq!((last.rigs, last.points, last.resolution), (4, FEWEST, SMALLEST));
        assert!(ladder.windows(2).all(|pair| pair[1].ms < pair[0].ms), "{ladder:?}");
    }

    #[test]
    fn gaps_are_filled_where_they_can_be() {
        let front = [
            rung(16, 1.0, Some(7), true, 1.0, 100.0),
            rung(16, 1.0, Some(7), true, 0.5, 50.0),
            rung(16, 1.0, Some(7), false, 0.5, 20.0),
            rung(4, 0.25, Some(7), false, 0.5, 10.0),
        ];
        let ladder = between(&front);
        let of = |ms: f64| ladder.iter().position(|rung| rung.ms == ms).expect("of the front");
        assert!(of(50.0) >= 6 && of(20.0) == of(50.0) + 1 && ladder.len() - of(20.0) >= 6);
        let half = &ladder[of(50.0) / 2];
        assert!(half.resolution < 0.8 && half.resolution > 0.6 && half.ms > 60.0, "{half:?}");
        let last = &ladder[ladder.len() - 2];
        assert!(last.rigs > 4 && last.rigs < 8 && last.points < 0.4, "{last:?}");
    }
}

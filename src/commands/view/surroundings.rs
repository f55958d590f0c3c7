//! The houses around someone who walks, asked for anew as they get on.

use std::time::{Duration, Instant};

use glam::DVec2;

use super::buildings::Buildings;

/// Houses are asked for so far around, metres; anew once one has gone half as far.
pub(super) const SURROUNDINGS_M: f64 = 600.0;
/// Where that fails, it is tried again after so long.
const PAUSE: Duration = Duration::from_secs(5);

/// What is known of them.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    buildings: Buildings,
    centre: Option<DVec2>,
    not_before: Option<Instant>,
    /// Of the last question; answers to former ones come too late.
    question: u64,
}

impl Surroundings {
    /// Whether someone at `place` has to ask, under which number.
    pub(super) fn ask(&mut self, place: DVec2, now: Instant) -> Option<u64> {
        let known = |centre: DVec2| centre.distance(place) < SURROUNDINGS_M / 2.0;
        if self.centre.is_some_and(known) || self.not_before.is_some_and(|then| now < then) {
            return None;
        }
        self.centre = Some(place);
        self.question += 1;
        Some(self.question)
    }

    /// The answer to a question; `None` where there was none.
    pub(super) fn take(&mut self, question: u64, found: Option<Buildings>, now: Instant) {
        if question != self.question {
            return;
        }
        match found {
            Some(buildings) => self.buildings = buildings,
            None => (self.centre, self.not_before) = (None, Some(now + PAUSE)),
        }
    }

    /// Forgets them all, as in another scene.
    pub(super) fn clear(&mut self) {
        *self = Self { question: self.question + 1, ..Self::default() };
    }

    /// The houses that are known.
    pub(super) fn buildings(&self) -> &Buildings {
        &self.buildings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_asks_again_once_one_has_gone_far_or_was_not_answered() {
        let (mut around, now) = (Surroundings::default(), Instant::now());
        let at = |x: f64| DVec2::new(651_000.0 + x, 6_861_000.0);
        let first = around.ask(at(0.0), now).expect("nothing is known");
        assert_eq!(around.ask(at(299.0), now), None);
        let second = around.ask(at(301.0), now).expect("far");
        around.take(first, None, now);
        assert_eq!(around.ask(at(301.0), now), None, "the first answer is of no interest");
        around.take(second, None, now);
        assert_eq!(around.ask(at(301.0), now), None, "not at once");
        let third = around.ask(at(301.0), now + PAUSE).expect("again");
        around.take(third, Some(Buildings::default()), now);
        assert_eq!(around.ask(at(301.0), now + PAUSE), None);
        around.clear();
        assert!(around.ask(at(301.0), now + PAUSE).is_some_and(|question| question > third));
    }
}

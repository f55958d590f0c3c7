//! The tape: the first click is its beginning, the second its end, the third begins anew.

use flaneur_renderer::Sight;
use glam::DVec3;

use super::measurement::Measurement;
use super::place::Place;

/// A tape in someone's hands, or put away.
#[derive(Debug, Default)]
pub(super) struct Measuring {
    on: bool,
    places: Vec<Place>,
    /// Answers that are still to come.
    asked: usize,
    /// Another one each time that the tape is taken up or put away.
    round: u64,
    /// The photograph that one wants to go to, and the place that it sees.
    chosen: Option<(Sight, DVec3)>,
}

impl Measuring {
    /// Whether clicks measure.
    pub(super) fn is_on(&self) -> bool {
        self.on
    }

    /// Takes the tape up, or puts it away.
    pub(super) fn toggle(&mut self) {
        *self = Self { on: !self.on, round: self.round + 1, ..Self::default() };
    }

    /// Puts it away.
    pub(super) fn close(&mut self) {
        if self.on {
            self.toggle();
        }
    }

    /// Someone clicks; the round that the answer belongs to.
    pub(super) fn ask(&mut self) -> u64 {
        self.asked += 1;
        self.round
    }

    /// What a click of a round met, in the order of clicks; nothing where nothing was surveyed.
    pub(super) fn take(&mut self, round: u64, place: Option<Place>) {
        if round != self.round {
            return;
        }
        self.asked = self.asked.saturating_sub(1);
        let Some(place) = place else { return };
        if self.places.len() >= 2 {
            self.places.clear();
        }
        self.places.push(place);
    }

    /// Whether an answer is still to come.
    pub(super) fn asks(&self) -> bool {
        self.asked > 0
    }

    /// The places so far, at most two.
    pub(super) fn places(&self) -> &[Place] {
        &self.places
    }

    /// The photographs that see the last place.
    pub(super) fn sights(&self) -> &[Sight] {
        self.places.last().map_or(&[], |place| &place.photographs)
    }

    /// Someone chooses one of them.
    pub(super) fn choose(&mut self, index: usize) {
        let place = self.places.last();
        let chosen = place.and_then(|place| {
            place.photographs.get(index).map(|sight| (sight.clone(), place.position))
        });
        self.chosen = chosen;
    }

    /// What was chosen since it was last asked.
    pub(super) fn take_chosen(&mut self) -> Option<(Sight, DVec3)> {
        self.chosen.take()
    }

    /// What lies between the two places, once there are two.
    pub(super) fn measurement(&self) -> Option<Measurement> {
        match self.places.as_slice() {
            [from, to] => Some(Measurement::between(from, to)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use flaneur_scene::ImageId;
    use glam::DVec2;

    use super::*;

    #[test]
    fn two_clicks_measure_and_a_third_begins_anew() {
        let at = |x: f64| Some(Place::on(DVec3::Z, DVec3::X * x));
        let mut tape = Measuring::default();
        tape.toggle();
        let (first, second) = (tape.ask(), tape.ask());
        tape.take(first, at(1.0));
        assert!(tape.is_on() && tape.asks() && tape.measurement().is_none());
        tape.take(second, at(4.0));
        let measured = tape.measurement().expect("two places");
        assert!(!tape.asks() && measured.distance == 3.0);
        assert!((measured.uncertainty.expect("known") - 0.05 * 2f64.sqrt()).abs() < 1e-12);
        let third = tape.ask();
        tape.take(third, None);
        assert_eq!(tape.measurement(), Some(measured), "nothing is there: the tape stays");
        let (fourth, late) = (tape.ask(), tape.ask());
        tape.take(fourth, at(9.0));
        assert_eq!((tape.places().len(), tape.measurement()), (1, None));
        assert!(tape.sights().is_empty());
        tape.choose(0);
        assert_eq!(tape.take_chosen(), None, "there is none");
        let id = ImageId::new("7", "left").expect("a name");
        let sight = Sight { id, pixel: DVec2::ZERO, distance_m: 4.0, share: 1.0 };
        let seen = Place { photographs: vec![sight.clone()], ..Place::on(DVec3::Z, DVec3::Y) };
        let fifth = tape.ask();
        tape.take(fifth, Some(seen));
        assert_eq!(tape.sights(), std::slice::from_ref(&sight));
        tape.choose(0);
        assert_eq!(tape.take_chosen(), Some((sight, DVec3::Y)));
        assert_eq!(tape.take_chosen(), None, "once");
        tape.close();
        tape.toggle();
        tape.take(late, at(2.0));
        assert!(tape.is_on() && tape.places().is_empty(), "of a tape that was put away");
    }
}

//! The tape: the first click is its beginning, the second its end, the third begins anew.

use flaneur_services::place::{Record, StoredSight};
use glam::DVec3;

use super::measurement::Measurement;
use super::place::Place;

/// A place that was clicked, and what is stored of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Marked {
    pub(super) place: Place,
    pub(super) stored: Stored,
}

/// What is stored of a place, which takes longer to learn than where it is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stored {
    Asked,
    Known(Box<Record>),
    /// It could not be had.
    Unknown,
}

/// A tape in someone's hands, or put away.
#[derive(Debug, Default)]
pub(super) struct Measuring {
    on: bool,
    places: Vec<Marked>,
    /// Places that were ever marked.
    marked: usize,
    /// Answers that are still to come.
    asked: usize,
    /// Another one each time that the tape is taken up or put away.
    round: u64,
    /// The photograph that one wants to see.
    chosen: Option<Chosen>,
}

/// A photograph of those that see a place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chosen {
    pub(super) sight: StoredSight,
    pub(super) place: DVec3,
}

impl Measuring {
    /// Whether clicks measure.
    pub(super) fn is_on(&self) -> bool {
        self.on
    }

    /// Takes the tape up, or puts it away.
    pub(super) fn toggle(&mut self) {
        let (round, marked) = (self.round + 1, self.marked);
        *self = Self { on: !self.on, round, marked, ..Self::default() };
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

    /// What a click of a round met, in the order of clicks; nothing where nothing was surveyed. Where
    /// the place is marked now, its number, by which to say what is stored of it.
    pub(super) fn take(&mut self, round: u64, place: Option<Place>) -> Option<usize> {
        if round != self.round {
            return None;
        }
        self.asked = self.asked.saturating_sub(1);
        let place = place?;
        if self.places.len() >= 2 {
            self.places.clear();
        }
        self.places.push(Marked { place, stored: Stored::Asked });
        self.marked += 1;
        Some(self.marked - 1)
    }

    /// What is stored of the place of a number, unless that is not marked any more.
    pub(super) fn learn(&mut self, number: usize, stored: Stored) {
        let first = self.marked - self.places.len();
        let index = number.checked_sub(first);
        if let Some(marked) = index.and_then(|index| self.places.get_mut(index)) {
            marked.stored = stored;
        }
    }

    /// Whether an answer is still to come.
    pub(super) fn asks(&self) -> bool {
        self.asked > 0 || self.places.iter().any(|marked| marked.stored == Stored::Asked)
    }

    /// The places so far, at most two.
    pub(super) fn places(&self) -> &[Marked] {
        &self.places
    }

    /// The photographs that see the last place.
    pub(super) fn sights(&self) -> &[StoredSight] {
        match self.places.last().map(|marked| &marked.stored) {
            Some(Stored::Known(record)) => &record.photographs,
            _ => &[],
        }
    }

    /// Someone chooses one of them.
    pub(super) fn choose(&mut self, index: usize) {
        let place = self.places.last().map(|marked| marked.place.position);
        self.chosen = self
            .sights()
            .get(index)
            .cloned()
            .zip(place)
            .map(|(sight, place)| Chosen { sight, place });
    }

    /// What was chosen since it was last asked.
    pub(super) fn take_chosen(&mut self) -> Option<Chosen> {
        self.chosen.take()
    }

    /// What lies between the two places, once there are two.
    pub(super) fn measurement(&self) -> Option<Measurement> {
        match self.places.as_slice() {
            [from, to] => Some(Measurement::between(&from.place, &to.place)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn at(x: f64) -> Option<Place> {
        Some(Place::on(DVec3::Z, DVec3::X * x))
    }

    /// Seen by one photograph, which was taken at `centre`.
    fn seen_from(centre: DVec3) -> Stored {
        let sight = StoredSight {
            panorama: "7".to_owned(),
            camera: "left".to_owned(),
            time: None,
            centre,
            pixel: DVec2::ZERO,
            distance_m: 4.0,
            share: 1.0,
        };
        Stored::Known(Box::new(Record { photographs: vec![sight], ..Record::default() }))
    }

    #[test]
    fn two_clicks_measure_and_a_third_begins_anew() {
        let mut tape = Measuring::default();
        tape.toggle();
        let (first, second) = (tape.ask(), tape.ask());
        tape.take(first, at(1.0));
        assert!(tape.is_on() && tape.asks() && tape.measurement().is_none());
        tape.take(second, at(4.0));
        let measured = tape.measurement().expect("two places");
        assert!(measured.distance == 3.0);
        assert!((measured.uncertainty.expect("known") - 0.05 * 2f64.sqrt()).abs() < 1e-12);
        let third = tape.ask();
        assert_eq!(tape.take(third, None), None);
        assert_eq!(tape.measurement(), Some(measured), "nothing is there: the tape stays");
        let (fourth, late) = (tape.ask(), tape.ask());
        tape.take(fourth, at(9.0));
        assert_eq!((tape.places().len(), tape.measurement()), (1, None));
        tape.close();
        tape.toggle();
        assert_eq!(tape.take(late, at(2.0)), None, "of a tape that was put away");
        assert!(tape.is_on() && tape.places().is_empty());
    }

    #[test]
    fn what_is_stored_of_a_place_comes_after_it() {
        let mut tape = Measuring::default();
        tape.toggle();
        let rounds = [tape.ask(), tape.ask(), tape.ask()];
        let first = tape.take(rounds[0], at(1.0)).expect("marked");
        assert!(tape.asks() && tape.sights().is_empty());
        tape.choose(0);
        assert_eq!(tape.take_chosen(), None, "there is none yet");
        let second = tape.take(rounds[1], at(2.0)).expect("marked");
        tape.learn(second, seen_from(DVec3::Y));
        assert!(tape.asks(), "of the first nothing is known");
        tape.choose(0);
        let chosen = tape.take_chosen().map(|chosen| [chosen.sight.centre, chosen.place]);
        assert_eq!(chosen, Some([DVec3::Y, DVec3::X * 2.0]));
        assert_eq!(tape.take_chosen(), None, "once");
        let third = tape.take(rounds[2], at(3.0)).expect("marked");
        tape.learn(first, seen_from(DVec3::Z));
        assert_eq!(tape.places()[0].stored, Stored::Asked, "the first is not marked any more");
        tape.learn(third, Stored::Unknown);
        assert!(!tape.asks() && tape.sights().is_empty());
        tape.toggle();
        tape.toggle();
        tape.learn(third, seen_from(DVec3::Z));
        let again = tape.ask();
        let fourth = tape.take(again, at(4.0)).expect("marked");
        assert!(fourth > third && tape.places()[0].stored == Stored::Asked);
    }
}

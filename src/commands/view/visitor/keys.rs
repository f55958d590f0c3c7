//! Keys that are held while one walks.

use std::time::{Duration, Instant};

/// A tap of a key lasts at least so long, or it would be of no effect.
const LEAST_TAP: Duration = Duration::from_millis(100);

/// A way to move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::commands::view) enum Step {
    /// Where one looks.
    Ahead,
    /// Away from there.
    Back,
    /// To one's left, without turning.
    Left,
    /// To one's right.
    Right,
    /// Turning to the left.
    TurnLeft,
    /// Turning to the right.
    TurnRight,
    /// Looking up.
    TiltUp,
    /// Looking down.
    TiltDown,
}

/// Which of them are under way.
#[derive(Debug, Default)]
pub(super) struct Keys {
    held: Vec<Key>,
}

#[derive(Debug)]
struct Key {
    step: Step,
    since: Instant,
    released: bool,
}

/// Which way to go: -1, 0 or 1 each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Course {
    pub(super) ahead: f64,
    pub(super) right: f64,
    pub(super) turn: f64,
    pub(super) tilt: f64,
}

impl Keys {
    /// A key goes down; again while it is down changes nothing.
    pub(super) fn press(&mut self, step: Step, now: Instant) {
        match self.held.iter_mut().find(|key| key.step == step) {
            Some(key) if key.released => *key = Key { step, since: now, released: false },
            Some(_) => {}
            None => self.held.push(Key { step, since: now, released: false }),
        }
    }

    /// A key goes up.
    pub(super) fn release(&mut self, step: Step) {
        self.held.iter_mut().filter(|key| key.step == step).for_each(|key| key.released = true);
    }

    /// All go up, as when the window is left.
    pub(super) fn release_all(&mut self) {
        self.held.clear();
    }

    /// What those that are down come to.
    pub(super) fn course(&mut self, now: Instant) -> Course {
        self.held.retain(|key| !key.released || now < key.since + LEAST_TAP);
        let mut course = Course::default();
        for key in &self.held {
            match key.step {
                Step::Ahead => course.ahead += 1.0,
                Step::Back => course.ahead -= 1.0,
                Step::Right => course.right += 1.0,
                Step::Left => course.right -= 1.0,
                Step::TurnRight => course.turn += 1.0,
                Step::TurnLeft => course.turn -= 1.0,
                Step::TiltUp => course.tilt += 1.0,
                Step::TiltDown => course.tilt -= 1.0,
            }
        }
        let unit = |sum: f64| sum.clamp(-1.0, 1.0);
        Course {
            ahead: unit(course.ahead),
            right: unit(course.right),
            turn: unit(course.turn),
            tilt: unit(course.tilt),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tap_counts_and_opposites_cancel() {
        let now = Instant::now();
        let later = |ms: u64| now + Duration::from_millis(ms);
        let mut keys = Keys::default();
        keys.press(Step::Ahead, now);
        keys.release(Step::Ahead);
        assert_eq!(keys.course(later(50)).ahead, 1.0);
        assert_eq!(keys.course(later(100)), Course::default());
        keys.press(Step::Left, now);
        keys.press(Step::Right, now);
        keys.press(Step::TurnLeft, now);
        assert_eq!(keys.course(later(500)), Course { turn: -1.0, ..Course::default() });
        keys.release(Step::Right);
        assert_eq!(keys.course(later(500)).right, -1.0);
        keys.press(Step::TiltUp, now);
        assert_eq!(keys.course(later(500)).tilt, 1.0);
        keys.release_all();
        assert_eq!(keys.course(later(500)), Course::default());
    }
}

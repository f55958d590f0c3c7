//! What a mouse means: a click, a double click, or a drag.

use std::time::{Duration, Instant};

use glam::DVec2;

/// Who moves the mouse less than this with the button down clicks, pixels.
const STILL_PX: f64 = 5.0;
/// Two clicks within this time, and this far from each other, are a double click.
const DOUBLE: Duration = Duration::from_millis(350);
const DOUBLE_PX: f64 = 8.0;

/// Where it is, and what its button does.
#[derive(Debug, Default)]
pub(super) struct Pointer {
    at: DVec2,
    held: Option<Held>,
    clicked: Option<(Instant, DVec2)>,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    from: DVec2,
    drags: bool,
}

/// A click that came to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clicked {
    pub(super) at: DVec2,
    pub(super) double: bool,
}

impl Pointer {
    /// It moves; from where to where it drags, if it does.
    pub(super) fn moves(&mut self, to: DVec2) -> Option<(DVec2, DVec2)> {
        let from = std::mem::replace(&mut self.at, to);
        let held = self.held.as_mut()?;
        if !held.drags && held.from.distance(to) < STILL_PX {
            return None;
        }
        let from = if held.drags { from } else { held.from };
        held.drags = true;
        Some((from, to))
    }

    /// Its button goes down.
    pub(super) fn press(&mut self) {
        self.held = Some(Held { from: self.at, drags: false });
    }

    /// Its button goes up.
    pub(super) fn release(&mut self, now: Instant) -> Option<Clicked> {
        let held = self.held.take().filter(|held| !held.drags)?;
        let before = self.clicked.take();
        let double = before.is_some_and(|(when, at)| {
            now.saturating_duration_since(when) < DOUBLE && at.distance(held.from) < DOUBLE_PX
        });
        self.clicked = (!double).then_some((now, held.from));
        Some(Clicked { at: held.from, double })
    }

    /// Where it is, pixels.
    pub(super) fn at(&self) -> DVec2 {
        self.at
    }

    /// It leaves with its button down.
    pub(super) fn lose(&mut self) {
        self.held = None;
    }

    /// Whether it drags.
    pub(super) fn drags(&self) -> bool {
        self.held.is_some_and(|held| held.drags)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clicks_are_told_from_drags_and_pairs_from_single_ones() {
        let (mut pointer, now) = (Pointer::default(), Instant::now());
        let at = |x: f64| DVec2::new(x, 50.0);
        assert_eq!(pointer.moves(at(100.0)), None);
        pointer.press();
        assert_eq!(pointer.moves(at(103.0)), None);
        let click = |x, double| Some(Clicked { at: at(x), double });
        assert_eq!(pointer.release(now), click(100.0, false));
        pointer.press();
        let soon = now + Duration::from_millis(200);
        assert_eq!(pointer.release(soon), click(103.0, true));
        pointer.press();
        assert_eq!(pointer.release(soon), click(103.0, false), "a third click is a first one");
        pointer.press();
        assert_eq!(pointer.release(soon + DOUBLE), click(103.0, false), "too late");
        pointer.press();
        assert_eq!(pointer.moves(at(110.0)), Some((at(103.0), at(110.0))));
        assert_eq!(pointer.moves(at(111.0)), Some((at(110.0), at(111.0))));
        assert!(pointer.drags() && pointer.release(soon).is_none());
        assert_eq!(pointer.moves(at(0.0)), None);
        pointer.press();
        pointer.lose();
        assert_eq!(pointer.release(soon), None);
    }
}

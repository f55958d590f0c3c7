//! The way from one pose to another, eased.

use std::f64::consts::PI;
use std::time::{Duration, Instant};

use super::super::pose::Pose;

/// A way of some length takes so long, and so much more for the root of each metre.
const LEAST_MS: f64 = 100.0;
const MS_A_ROOT: f64 = 30.0;
/// Turning on the spot takes as long as going this far for a whole half turn, metres.
const HALF_TURN_M: f64 = 100.0;

/// A movement under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Glide {
    from: Pose,
    to: Pose,
    began: Instant,
    takes: Duration,
}

impl Glide {
    /// From one pose to another, beginning now.
    pub(super) fn new(from: Pose, to: Pose, now: Instant) -> Self {
        let turned = HALF_TURN_M * from.turn_to(&to) / PI;
        let ms = LEAST_MS + MS_A_ROOT * from.eye.distance(to.eye).max(turned).sqrt();
        Self { from, to, began: now, takes: Duration::from_secs_f64(ms / 1e3) }
    }

    /// Where it ends.
    pub(super) fn end(&self) -> Pose {
        self.to
    }

    /// Where it is, and whether it is there.
    pub(super) fn at(&self, now: Instant) -> (Pose, bool) {
        let passed = now.saturating_duration_since(self.began);
        if passed >= self.takes {
            return (self.to, true);
        }
        let share = passed.as_secs_f64() / self.takes.as_secs_f64();
        (self.from.towards(&self.to, share * share * (3.0 - 2.0 * share)), false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_way_of_25_metres_takes_a_quarter_of_a_second() {
        let from = Pose::new(DVec3::ZERO, 0.0, 0.0, 1.0);
        let to = from.at(DVec3::Y * 25.0);
        let began = Instant::now();
        let glide = Glide::new(from, to, began);
        let at = |ms: u64| glide.at(began + Duration::from_millis(ms));
        assert_eq!(at(0), (from, false));
        assert!((at(125).0.eye.y - 12.5).abs() < 1e-9);
        assert!(!at(249).1 && at(250) == (to, true));
        // It starts and ends slowly.
        assert!(at(10).0.eye.y < 0.2 && at(240).0.eye.y > 24.8);
        // A quarter turn is as far as 50 metres.
        let turn = Glide::new(from, from.turned(PI / 2.0, 0.1), began);
        assert!((turn.takes.as_secs_f64() - 0.312).abs() < 1e-3);
    }
}

//! Where someone who moves will be soon.

use std::time::Duration;

use flaneur_scene::View;
use glam::DVec3;
use tokio::time::Instant;

/// How far ahead is looked: what a slow connection takes to bring a photograph.
const AHEAD: Duration = Duration::from_secs(2);
/// Views farther apart in time do not belong to one motion.
const PAUSE: Duration = Duration::from_secs(1);
/// Slower is standing, faster is a jump, metres a second.
const SPEEDS_M_S: std::ops::Range<f64> = 0.2..30.0;
/// Weight of the newest of several speeds.
const NEWEST: f64 = 0.3;

/// The motion that the last views are part of.
#[derive(Debug, Default)]
pub(super) struct Motion {
    last: Option<(Instant, DVec3)>,
    /// Metres a second.
    velocity: Option<DVec3>,
}

impl Motion {
    /// Takes note of a view.
    pub(super) fn note(&mut self, view: &View, now: Instant) {
        let eye = view.eye();
        if let Some((at, before)) = self.last.replace((now, eye)) {
            let passed = now.duration_since(at);
            let velocity = (eye - before) / passed.as_secs_f64().max(1e-3);
            self.velocity = (passed <= PAUSE && velocity.length() < SPEEDS_M_S.end)
                .then(|| self.velocity.map_or(velocity, |usual| usual.lerp(velocity, NEWEST)));
        }
    }

    /// The view that comes after `view` if the motion goes on; `None` where nobody moves.
    pub(super) fn ahead(&self, view: &View) -> Option<View> {
        let velocity = self.velocity.filter(|v| SPEEDS_M_S.contains(&v.length()))?;
        let mut ahead = *view;
        ahead.camera.centre += velocity * AHEAD.as_secs_f64();
        Some(ahead)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    #[test]
    fn who_walks_goes_on_and_who_stands_or_jumps_does_not() {
        let view = |x: f64| View::look(DVec3::new(x, 0.0, 1.6), 0.0, 0.0, 1.0, UVec2::new(64, 32));
        let (mut motion, mut now) = (Motion::default(), Instant::now());
        for step in 0..20 {
            motion.note(&view(0.14 * f64::from(step)), now);
            now += Duration::from_millis(100);
        }
        let ahead = motion.ahead(&view(2.66)).expect("moving").eye().x;
        assert!((ahead - 2.66 - 2.8).abs() < 1e-6, "{ahead}");
        motion.note(&view(500.0), now);
        assert!(motion.ahead(&view(500.0)).is_none(), "a jump");
        for _ in 0..20 {
            now += Duration::from_millis(100);
            motion.note(&view(500.0), now);
        }
        assert!(motion.ahead(&view(500.0)).is_none(), "standing");
    }
}

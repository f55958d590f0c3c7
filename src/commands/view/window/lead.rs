//! Frames for a turning head: they show where it will look by when they are there, and a little more.

use std::f64::consts::{PI, TAU};
use std::time::{Duration, Instant};

use flaneur_scene::View;
use glam::UVec2;

use crate::commands::view::pose::Pose;

/// Frames are asked for no farther ahead of a turning head, radians.
const FARTHEST: f64 = 25.0 / 180.0 * PI;
/// Its speed is that of the last moments, seconds.
const MEMORY_S: f64 = 0.08;
/// A frame is seen for as long as the next one takes to draw; in the middle of that it is this many
/// times as old as it took.
const AGE: f64 = 1.5;
/// How much wider and higher than the window a frame is while the head turns. It has no more pixels.
const MARGIN: f64 = 1.2;
/// Who turns more slowly than this does not turn, radians a second.
const STILL: f64 = 0.02;
/// No view is wider, radians.
const WIDEST: f64 = 160.0 / 180.0 * PI;

/// How a head turns, and how late frames come.
#[derive(Debug)]
pub(super) struct Lead {
    /// Radians a second, clockwise.
    turning: f64,
    noted: Option<(Instant, f64)>,
    /// What a frame takes, seconds, smoothed.
    took_s: f64,
}

impl Lead {
    /// Of someone who has not turned yet.
    pub(super) fn new() -> Self {
        Self { turning: 0.0, noted: None, took_s: 0.1 }
    }

    /// The head is there now.
    pub(super) fn note(&mut self, pose: &Pose, now: Instant) {
        if let Some((before, heading)) = self.noted {
            let seconds = now.saturating_duration_since(before).as_secs_f64().clamp(4e-3, MEMORY_S);
            let turn = (pose.heading - heading + PI).rem_euclid(TAU) - PI;
            self.turning += seconds / MEMORY_S * (turn / seconds - self.turning);
        }
        self.noted = Some((now, pose.heading));
    }

    /// A frame on the way took so long.
    pub(super) fn took(&mut self, time: Duration) {
        self.took_s += 0.25 * (time.as_secs_f64() - self.took_s);
    }

    /// What to draw, `size` pixels large, for a head that is at `pose` now.
    pub(super) fn view(&self, pose: &Pose, size: UVec2) -> View {
        if self.turning.abs() < STILL {
            return pose.view(size);
        }
        let lead = (self.turning * AGE * self.took_s).clamp(-FARTHEST, FARTHEST);
        let fov_y = 2.0 * (MARGIN * (pose.fov_y / 2.0).tan()).atan();
        let there = pose.turned(lead, 0.0);
        View::look(there.eye, there.heading, there.pitch, fov_y.min(WIDEST), size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_turning_head_is_shown_what_it_will_see() {
        let size = UVec2::new(640, 360);
        let (began, mut lead) = (Instant::now(), Lead::new());
        // Across north, at 60 degrees a second, with frames of 100 ms.
        let at = |ms: u64| {
            Pose::new(DVec3::ZERO, (f64::from(ms as u32) * 0.06 - 20.0).to_radians(), 0.0, 1.0)
        };
        lead.note(&at(0), began);
        assert_eq!(lead.view(&at(0), size), at(0).view(size), "who stands gets what they see");
        for ms in (16..=640).step_by(16) {
            lead.note(&at(ms), began + Duration::from_millis(ms));
            lead.took(Duration::from_millis(100));
        }
        let view = lead.view(&at(640), size);
        let (ahead, _) = view
            .camera
            .project(at(790).view(size).ray(size.as_dvec2() / 2.0).expect("a ray").direction)
            .expect("ahead");
        assert!(ahead.distance(size.as_dvec2() / 2.0) < 2.0, "{ahead}");
        let focal = at(0).view(size).camera.lens.intrinsics.fy;
        assert!((view.camera.lens.intrinsics.fy * MARGIN - focal).abs() < 1e-6);
        // Who stops is waited for.
        for ms in (656..1200).step_by(16) {
            lead.note(&at(640), began + Duration::from_millis(ms));
        }
        assert_eq!(lead.view(&at(640), size), at(640).view(size));
    }
}

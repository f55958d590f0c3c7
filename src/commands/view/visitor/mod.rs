//! Someone who looks and walks about: what they do, in; where they stand, out. No window, no clock.

mod before;
mod glide;
mod keys;
mod slide;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;
use std::ops::RangeInclusive;
use std::time::Instant;

use glam::{DVec2, DVec3, UVec2};

use super::buildings::Walls;
use super::ground::Ground;
use super::place::{Place, PlaceKind};
use super::pose::Pose;
use before::before;
use glide::Glide;
use keys::Keys;
pub(super) use keys::Step;
use slide::slid;

/// Eyes of someone who comes down to the ground are so far above it, metres.
pub(super) const EYE_HEIGHT: f64 = 1.6;

/// Metres a second, and how much more with Shift.
const SPEED: f64 = 3.0;
const HASTE: f64 = 3.0;
/// Radians a second, with a field of view as wide as the second figure, radians, or wider; with a narrow
/// one a degree is a long way.
const TURN: f64 = 75.0 / 180.0 * PI;
const WIDE: f64 = 65.0 / 180.0 * PI;
/// An eye within this range above the ground is that of someone who walks, metres; others fly.
const WALKING: RangeInclusive<f64> = 0.3..=8.0;
/// How fast an eye follows the ground: the share of the difference that is left after a second is
/// e to the minus this.
const FOLLOWING: f64 = 8.0;
/// A longer time between two looks at the clock is taken for this, seconds: whoever was away does
/// not run on meanwhile.
const LONGEST_STEP_S: f64 = 0.25;

/// A visitor.
#[derive(Debug)]
pub(super) struct Visitor {
    pose: Pose,
    /// Above the ground, of someone who walks; known once the ground is.
    eye_height: Option<f64>,
    keys: Keys,
    hurries: bool,
    glide: Option<Glide>,
    clock: Instant,
}

impl Visitor {
    /// Someone who stands at `pose`.
    pub(super) fn new(pose: Pose, now: Instant) -> Self {
        let keys = Keys::default();
        Self { pose, eye_height: None, keys, hurries: false, glide: None, clock: now }
    }

    /// Where they stand and look.
    pub(super) fn pose(&self) -> Pose {
        self.pose
    }

    /// They begin to move; again while they do changes nothing.
    pub(super) fn press(&mut self, step: Step, now: Instant) {
        self.glide = None;
        self.keys.press(step, now);
    }

    /// They stop doing so.
    pub(super) fn release(&mut self, step: Step) {
        self.keys.release(step);
    }

    /// They stop whatever they do with keys.
    pub(super) fn release_all(&mut self) {
        self.keys.release_all();
    }

    /// Whether they hurry.
    pub(super) fn hurry(&mut self, hurries: bool) {
        self.hurries = hurries;
    }

    /// They take hold of the picture, `size` pixels large, at one place and drag it to another: what
    /// is at the one is then at the other, but for the roll that nobody has.
    pub(super) fn drag(&mut self, from: DVec2, to: DVec2, size: UVec2) {
        self.glide = None;
        let intrinsics = self.pose.view(size).camera.lens.intrinsics;
        let angles = |pixel: DVec2| {
            let p = intrinsics.normalised_from_pixel(pixel);
            DVec2::new(p.x.atan(), p.y.atan())
        };
        let turn = angles(from) - angles(to);
        // Off the horizon the same turn of the head moves the picture less.
        let heading = turn.x / self.pose.pitch.cos().max(0.2);
        self.pose = self.pose.turned(heading, -turn.y);
    }

    /// They narrow (> 1) or widen (< 1) the view of `size` pixels; what is at the pixel `about` stays
    /// there.
    pub(super) fn zoom(&mut self, factor: f64, about: DVec2, size: UVec2) {
        self.glide = None;
        let angles = |pose: &Pose| {
            let ray = pose.view(size).ray(about)?;
            let there = pose.facing(pose.eye + ray.direction);
            Some(DVec2::new(there.heading, there.pitch))
        };
        let zoomed = self.pose.zoomed(1.0 / factor);
        let turn =
            angles(&self.pose).zip(angles(&zoomed)).map_or(DVec2::ZERO, |(was, is)| was - is);
        self.pose = zoomed.turned(turn.x, turn.y);
    }

    /// They go to a pose; the height above the ground is what it is there.
    pub(super) fn go(&mut self, to: Pose, now: Instant) {
        self.eye_height = None;
        self.glide = Some(Glide::new(self.pose, to, now));
    }

    /// They look level.
    pub(super) fn level(&mut self, now: Instant) {
        let level = Pose { pitch: 0.0, ..self.pose };
        self.glide = Some(Glide::new(self.pose, level, now));
    }

    /// Where they are going, if they go by themselves.
    pub(super) fn destination(&self) -> Option<Pose> {
        self.glide.as_ref().map(Glide::end)
    }

    /// They go to a place on the ground, face a wall, and turn to what is neither.
    pub(super) fn go_to(&mut self, place: &Place, now: Instant, ground: &Ground) {
        match place.kind(ground.height(place.position.truncate())) {
            PlaceKind::Ground => {
                self.go(self.pose.at(place.position + DVec3::Z * EYE_HEIGHT), now);
                self.eye_height = Some(EYE_HEIGHT);
            }
            PlaceKind::Wall => self.go(before(place, self.pose, ground), now),
            PlaceKind::Other => self.go(self.pose.facing(place.position), now),
        }
    }

    /// Lets time pass until `now`; whether they move. Who walks goes along walls, and who flies over them.
    pub(super) fn advance(&mut self, now: Instant, ground: &Ground, walls: &impl Walls) -> bool {
        let seconds = now.saturating_duration_since(self.clock).as_secs_f64().min(LONGEST_STEP_S);
        self.clock = now;
        let before = self.pose;
        if let Some(glide) = self.glide {
            let (pose, arrived) = glide.at(now);
            self.pose = pose;
            if arrived {
                self.glide = None;
            }
            return true;
        }
        let course = self.keys.course(now);
        let [ahead, right] = self.pose.ahead_and_right();
        let speed = if self.hurries { SPEED * HASTE } else { SPEED };
        let way = ahead * course.ahead + right * course.right;
        let way = way.normalize_or_zero() * speed * seconds;
        let way = if self.flies(ground) { way } else { slid(self.pose.eye.truncate(), way, walls) };
        let moved = self.pose.eye + way.extend(0.0);
        let turn = TURN * seconds * (self.pose.fov_y / WIDE).min(1.0);
        self.pose = self.pose.at(moved).turned(course.turn * turn, course.tilt * turn);
        self.follow(ground, seconds);
        !self.pose.is_like(&before)
    }

    /// Whether they are too high above the ground to walk on it.
    fn flies(&self, ground: &Ground) -> bool {
        let height = ground.height(self.pose.eye.truncate());
        height.is_some_and(|height| !WALKING.contains(&(self.pose.eye.z - height)))
    }

    /// Keeps the eye as high above the ground as it was.
    fn follow(&mut self, ground: &Ground, seconds: f64) {
        let Some(height) = ground.height(self.pose.eye.truncate()) else { return };
        let above = self.pose.eye.z - height;
        let Some(eye_height) = self.eye_height else {
            self.eye_height = WALKING.contains(&above).then_some(above);
            return;
        };
        let left = (above - eye_height) * (-FOLLOWING * seconds).exp();
        let left = if left.abs() < 1e-3 { 0.0 } else { left };
        self.pose.eye.z = height + eye_height + left;
    }
}

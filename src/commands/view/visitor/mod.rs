//! Someone who looks and walks about: what they do, in; where they stand, out. No window, no clock.

mod glide;
mod keys;
#[cfg(test)]
mod tests;

use std::time::Instant;

use glam::{DVec2, DVec3, UVec2};

use super::ground::Ground;
use super::place::Place;
use super::pose::Pose;
use glide::Glide;
use keys::Keys;
pub(super) use keys::Step;

/// Metres a second, and how much more with Shift.
const SPEED: f64 = 4.0;
const HASTE: f64 = 4.0;
/// Radians a second.
const TURN: f64 = 1.2;
/// An eye within this range above the ground is that of someone who walks, metres; others fly.
const EYE_HEIGHT: [f64; 2] = [0.3, 8.0];
/// How tall someone is who comes down to the ground, metres.
const STANDING: f64 = 1.7;
/// How fast an eye follows the ground: the share of the difference that is left after a second is
/// e to the minus this.
const FOLLOWING: f64 = 8.0;
/// How near one stays to a wall to face it, and how far off at most, metres.
const BEFORE_WALL: [f64; 2] = [2.0, 12.0];
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

    /// They zoom in, by so many notches of a wheel.
    pub(super) fn zoom(&mut self, notches: f64) {
        self.pose = self.pose.zoomed((-0.1 * notches).exp());
    }

    /// They go to a pose.
    pub(super) fn go(&mut self, to: Pose, now: Instant) {
        self.glide = Some(Glide::new(self.pose, to, now));
    }

    /// They go to a place: onto the ground, or before a wall, which they then face.
    pub(super) fn go_to(&mut self, place: &Place, now: Instant) {
        let to = if place.is_level() {
            let height = self.eye_height.unwrap_or(STANDING);
            self.eye_height = Some(height);
            self.pose.at(place.position + DVec3::Z * height)
        } else {
            before(place, self.pose)
        };
        self.go(to, now);
    }

    /// Lets time pass until `now`; whether they move.
    pub(super) fn advance(&mut self, now: Instant, ground: &Ground) -> bool {
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
        let moved = self.pose.eye + way.extend(0.0);
        self.pose = self.pose.at(moved).turned(course.turn * TURN * seconds, 0.0);
        self.follow(ground, seconds);
        !self.pose.is_like(&before)
    }

    /// Keeps the eye as high above the ground as it was.
    fn follow(&mut self, ground: &Ground, seconds: f64) {
        let Some(height) = ground.height(self.pose.eye.truncate()) else { return };
        let above = self.pose.eye.z - height;
        let Some(eye_height) = self.eye_height else {
            let walks = (EYE_HEIGHT[0]..=EYE_HEIGHT[1]).contains(&above);
            self.eye_height = walks.then_some(above);
            return;
        };
        let left = (above - eye_height) * (-FOLLOWING * seconds).exp();
        let left = if left.abs() < 1e-3 { 0.0 } else { left };
        self.pose.eye.z = height + eye_height + left;
    }
}

/// The pose before a wall from which one looks straight at `place`, as high as now and as far from the
/// wall's plane: farther off one would stand in the houses across the street.
fn before(place: &Place, pose: Pose) -> Pose {
    let out = place.normal.truncate().normalize_or_zero();
    let distance = (pose.eye - place.position).truncate().dot(out);
    let distance = distance.clamp(BEFORE_WALL[0], BEFORE_WALL[1]);
    let eye = (place.position.truncate() + out * distance).extend(pose.eye.z);
    pose.at(eye).facing(place.position.with_z(pose.eye.z))
}

//! Where someone stands, and where they look.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;

use flaneur_scene::View;
use glam::{DVec2, DVec3, UVec2};

/// The narrowest and the widest vertical field of view, radians: 5 and 110 degrees.
const FOV: [f64; 2] = [PI / 36.0, 11.0 / 18.0 * PI];

/// An eye and its direction; no roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    /// World, metres.
    pub(super) eye: DVec3,
    /// Clockwise from grid north, radians, 0 to 2 pi.
    pub(super) heading: f64,
    /// Up, radians, at most a right angle either way.
    pub(super) pitch: f64,
    /// Vertical field of view, radians.
    pub(super) fov_y: f64,
}

impl Pose {
    /// A pose with its angles brought into range.
    pub(super) fn new(eye: DVec3, heading: f64, pitch: f64, fov_y: f64) -> Self {
        Self {
            eye,
            heading: heading.rem_euclid(TAU),
            pitch: pitch.clamp(-FRAC_PI_2, FRAC_PI_2),
            fov_y: fov_y.clamp(FOV[0], FOV[1]),
        }
    }

    /// What is seen, `size` pixels large.
    pub(super) fn view(&self, size: UVec2) -> View {
        View::look(self.eye, self.heading, self.pitch, self.fov_y, size)
    }

    /// The same eye, turned by so much, radians.
    pub(super) fn turned(&self, heading: f64, pitch: f64) -> Self {
        Self::new(self.eye, self.heading + heading, self.pitch + pitch, self.fov_y)
    }

    /// The same with a field of view `factor` times as wide.
    pub(super) fn zoomed(&self, factor: f64) -> Self {
        Self::new(self.eye, self.heading, self.pitch, self.fov_y * factor)
    }

    /// The same direction from elsewhere.
    pub(super) fn at(&self, eye: DVec3) -> Self {
        Self { eye, ..*self }
    }

    /// The same eye, turned to `place`; unchanged where that is where it stands.
    pub(super) fn facing(&self, place: DVec3) -> Self {
        let way = place - self.eye;
        let level = way.truncate().length();
        if level.hypot(way.z) < 1e-9 {
            return *self;
        }
        let heading = if level > 1e-9 { way.x.atan2(way.y) } else { self.heading };
        Self::new(self.eye, heading, way.z.atan2(level), self.fov_y)
    }

    /// The horizontal directions ahead and to the right, world.
    pub(super) fn ahead_and_right(&self) -> [DVec2; 2] {
        let (sin, cos) = self.heading.sin_cos();
        [DVec2::new(sin, cos), DVec2::new(cos, -sin)]
    }

    /// What lies at `share`, 0 to 1, of the way to `other`: on a line, turning the short way.
    pub(super) fn towards(&self, other: &Self, share: f64) -> Self {
        let between = |a: f64, b: f64| a + share * (b - a);
        let turn = (other.heading - self.heading + PI).rem_euclid(TAU) - PI;
        Self::new(
            self.eye.lerp(other.eye, share),
            self.heading + share * turn,
            between(self.pitch, other.pitch),
            between(self.fov_y, other.fov_y),
        )
    }

    /// How far one turns to look as `other` does, radians: the larger of heading and pitch.
    pub(super) fn turn_to(&self, other: &Self) -> f64 {
        let heading = (other.heading - self.heading + PI).rem_euclid(TAU) - PI;
        heading.abs().max((other.pitch - self.pitch).abs())
    }

    /// Whether two poses show the same, as far as anyone could tell.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let angle = self.turn_to(other).max((other.fov_y - self.fov_y).abs());
        self.eye.distance(other.eye) < 1e-4 && angle < 1e-5
    }
}

/// As people give it: position, heading and pitch in degrees.
impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (eye, heading, pitch) = (self.eye, self.heading.to_degrees(), self.pitch.to_degrees());
        write!(f, "{:.3},{:.3},{:.3},{heading:.3},{pitch:.3}", eye.x, eye.y, eye.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_faces_a_place_in_the_middle_of_its_view() {
        let eye = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        let place = eye + DVec3::new(-3.0, -4.0, 2.0);
        let pose = Pose::new(eye, 1.0, 0.2, 1.0).facing(place);
        let view = pose.view(UVec2::new(640, 480));
        let (pixel, _) = view.camera.project(place).expect("ahead");
        assert!(pixel.distance(DVec2::new(320.0, 240.0)) < 1e-6, "{pixel}");
        assert_eq!(pose.facing(eye), pose);
        assert_eq!(pose.facing(eye + DVec3::Z).heading, pose.heading);
        let [ahead, right] = pose.ahead_and_right();
        assert!(ahead.distance(DVec2::new(-0.6, -0.8)) < 1e-9 && ahead.perp_dot(right) < 0.0);
    }

    #[test]
    fn between_poses_one_turns_the_short_way() {
        let a = Pose::new(DVec3::ZERO, -0.1, 0.0, 1.0);
        let b = Pose::new(DVec3::X * 10.0, 0.3, 0.2, 1.2);
        let half = a.towards(&b, 0.5);
        assert!(half.is_like(&Pose::new(DVec3::X * 5.0, 0.1, 0.1, 1.1)), "{half:?}");
        assert!(a.towards(&b, 1.0).is_like(&b) && !a.is_like(&b));
        assert!(Pose::new(DVec3::ZERO, TAU - 1e-9, 9.0, 9.0).pitch <= FRAC_PI_2);
    }
}

//! The cone around everything that a view sees.

use flaneur_scene::{Bounds3, View, ViewProjection};
use glam::{DVec2, DVec3};

/// Points along each border of the picture from which the cone is found. Between two of them
/// the border of a strongly distorted picture bulges by less than [`MARGIN`].
const BORDER_STEPS: u32 = 16;
/// Added to the cone's half angle, radians.
const MARGIN: f64 = 0.02;

/// A cone with its apex at the eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct ViewCone {
    eye: DVec3,
    axis: DVec3,
    /// Half its opening, radians; π where the view may see everything.
    half_angle: f64,
    /// Sine and cosine of that.
    sine: f64,
    cosine: f64,
}

impl ViewCone {
    /// The cone of `view`: everything, where its lens does not reach its picture's border.
    pub(super) fn new(view: &View) -> Self {
        let size = view.size().as_dvec2();
        let border = (0..=BORDER_STEPS).flat_map(|step| {
            let along = f64::from(step) / f64::from(BORDER_STEPS);
            [(along, 0.0), (along, 1.0), (0.0, along), (1.0, along)]
        });
        let mut half_angle: f64 = 0.0;
        for (x, y) in border {
            match view.camera.lens.unproject(DVec2::new(x, y) * size) {
                Some(d) => half_angle = half_angle.max(d.angle_between(DVec3::Z)),
                None => half_angle = std::f64::consts::PI,
            }
        }
        // Parallel rays have no apex.
        if view.projection == ViewProjection::Orthographic {
            half_angle = std::f64::consts::PI;
        }
        let half_angle = (half_angle + MARGIN).min(std::f64::consts::PI);
        let (sine, cosine) = half_angle.sin_cos();
        Self { eye: view.eye(), axis: view.camera.forward(), half_angle, sine, cosine }
    }

    /// Half its opening, radians.
    pub(super) fn half_angle(&self) -> f64 {
        self.half_angle
    }

    /// Whether the ball around `bounds` reaches into the cone. True for a box whenever it is
    /// true for a box inside it, if both are cubes.
    pub(super) fn meets(&self, bounds: &Bounds3) -> bool {
        let radius = 0.5 * bounds.max.distance(bounds.min);
        self.meets_ball(bounds.centre() - self.eye, radius)
    }

    /// The same of a ball, its centre relative to the eye, without a trigonometric function.
    pub(super) fn meets_ball(&self, centre: DVec3, radius: f64) -> bool {
        let along = centre.dot(self.axis);
        let square = centre.length_squared();
        if square <= radius * radius || self.half_angle >= std::f64::consts::PI {
            return true;
        }
        let beside = (square - along * along).max(0.0).sqrt();
        // The centre is d sin(a - h) from the cone, a its angle and h the half angle, and nearest
        // to the apex where it is more than a quarter turn away from it.
        let ahead = along * self.cosine + beside * self.sine;
        let off = beside * self.cosine - along * self.sine;
        off <= 0.0 || (ahead > 0.0 && off <= radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    #[test]
    fn what_lies_ahead_is_met_and_what_lies_behind_is_not() {
        let eye = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        let view = View::look(eye, 0.0, 0.0, 1.0, UVec2::new(100, 100));
        let cone = ViewCone::new(&view);
        let cube = |at: DVec3, half: f64| Bounds3 { min: eye + at - half, max: eye + at + half };
        assert!(cone.meets(&cube(DVec3::Y * 10.0, 1.0)));
        assert!(!cone.meets(&cube(DVec3::Y * -10.0, 1.0)));
        assert!(!cone.meets(&cube(DVec3::X * 10.0, 1.0)));
        assert!(cone.meets(&cube(DVec3::X * 10.0, 8.0)), "reaches into view");
        assert!(cone.meets(&cube(DVec3::Y * -1.0, 2.0)), "the eye is inside its ball");
    }

    /// The same by angles, for cones of every opening.
    #[test]
    fn balls_meet_the_cone_where_their_angles_say_so() {
        for fov in [0.3, 1.0, 2.0, 2.8] {
            let view = View::look(DVec3::ZERO, 0.4, 0.2, fov, UVec2::new(300, 200));
            let cone = ViewCone::new(&view);
            for i in 0..4000 {
                let turn = f64::from(i) * 2.399_963;
                let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 4000.0;
                let aside = (1.0 - z * z).sqrt();
                let direction = DVec3::new(aside * turn.cos(), aside * turn.sin(), z);
                let (distance, radius) = (5.0 + f64::from(i % 7), 0.3 * f64::from(i % 11));
                let angle = direction.angle_between(cone.axis) - (radius / distance).asin();
                if (angle - cone.half_angle).abs() > 1e-9 {
                    let met = cone.meets_ball(direction * distance, radius);
                    assert_eq!(met, angle <= cone.half_angle, "{direction} {distance} {radius}");
                }
            }
        }
    }
}

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
        Self { eye: view.eye(), axis: view.camera.forward(), half_angle: half_angle + MARGIN }
    }

    /// Whether the ball around `bounds` reaches into the cone. True for a box whenever it is
    /// true for a box inside it, if both are cubes.
    pub(super) fn meets(&self, bounds: &Bounds3) -> bool {
        let (to_centre, radius) =
            (bounds.centre() - self.eye, 0.5 * bounds.max.distance(bounds.min));
        let distance = to_centre.length();
        if distance <= radius {
            return true;
        }
        let angle = to_centre.angle_between(self.axis);
        angle - (radius / distance).asin() <= self.half_angle
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
}

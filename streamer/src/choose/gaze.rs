//! Where someone looks: what lies there counts more.

use flaneur_scene::View;
use glam::{DVec2, DVec3};

use super::cone::ViewCone;

/// The direction of a gaze, and how fast what is beside it counts less.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gaze {
    direction: DVec3,
    /// Angle at which half is left, radians.
    half_at: f64,
}

impl Gaze {
    /// The gaze at `pixel` of `view`, its centre where `None`. What is as far from it as the view's
    /// corner is from its centre counts half.
    pub(super) fn new(view: &View, pixel: Option<DVec2>, cone: &ViewCone) -> Self {
        let pixel = pixel.unwrap_or(0.5 * view.size().as_dvec2());
        let ray = view.ray(pixel).and_then(|ray| ray.direction.try_normalize());
        Self { direction: ray.unwrap_or(view.camera.forward()), half_at: cone.half_angle() }
    }

    /// What the nearest part of a ball to the gaze counts, its centre relative to the eye: 1 on the
    /// gaze, and no more for a ball inside than for the ball around it.
    pub(super) fn weight(&self, centre: DVec3, radius: f64) -> f64 {
        let along = centre.dot(self.direction);
        let square = centre.length_squared();
        if square <= radius * radius {
            return 1.0;
        }
        let angle = (square - along * along).max(0.0).sqrt().atan2(along);
        let off = (angle - (radius / square.sqrt()).asin()).max(0.0) / self.half_at;
        1.0 / (1.0 + off * off)
    }
}

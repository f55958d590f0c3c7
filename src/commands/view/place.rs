//! Places on surfaces, as one clicks them.

use flaneur_renderer::{Picked, PickedSurface};
use flaneur_scene::{SurfaceClass, View};
use glam::DVec3;

/// Higher above the terrain a point is not on the ground, metres.
const STEP: f64 = 0.4;
/// Points on surfaces that lean less than this from the upright are on walls, and where the terrain is
/// not known those that lean more than this are on the ground: sines.
const UPRIGHT: f64 = 0.4;
const LEVEL: f64 = 0.7;
/// No surface is seen more askew, as a sine: it is an edge.
const ASKEW: f64 = 0.1;

/// A place on a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    /// World, metres.
    pub(super) position: DVec3,
    /// Of the surface, towards the eye, a unit vector.
    pub(super) normal: DVec3,
    /// How far the surface may be from there, metres; 0 where nobody knows.
    pub(super) uncertainty_m: f64,
    /// What was surveyed there.
    pub(super) surface: PickedSurface,
    /// How far it may be from what was meant, metres (one standard deviation); `None` where nobody knows.
    pub(super) off_m: Option<f64>,
}

/// What one does at a place: go there, face it, or look at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlaceKind {
    Ground,
    Wall,
    Other,
}

impl Place {
    /// What a click met in a view. A hand is a pixel off, and the surface may be nearer or farther than it
    /// was surveyed: seen askew, both are farther along it.
    pub(super) fn met(view: &View, picked: &Picked) -> Self {
        let ray = picked.position - view.eye();
        let away_m = ray.length();
        let across_m = picked.uncertainty_m.hypot(away_m / view.camera.lens.intrinsics.fy);
        let facing = picked.normal.dot(ray).abs() / away_m.max(1e-9);
        Self {
            position: picked.position,
            normal: picked.normal,
            uncertainty_m: picked.uncertainty_m,
            surface: picked.surface,
            off_m: (picked.uncertainty_m > 0.0).then(|| across_m / facing.max(ASKEW)),
        }
    }

    /// Which of them it is, where the terrain is as high as `ground`, if that is known.
    pub(super) fn kind(&self, ground: Option<f64>) -> PlaceKind {
        match self.surface {
            PickedSurface::Mesh(SurfaceClass::Ground) => PlaceKind::Ground,
            PickedSurface::Mesh(SurfaceClass::Wall) => PlaceKind::Wall,
            PickedSurface::Mesh(SurfaceClass::Roof) => PlaceKind::Other,
            PickedSurface::Point => {
                let on_ground = |height: f64| (self.position.z - height).abs() < STEP;
                if ground.map_or(self.normal.z > LEVEL, on_ground) {
                    PlaceKind::Ground
                } else if self.normal.z.abs() < UPRIGHT {
                    PlaceKind::Wall
                } else {
                    PlaceKind::Other
                }
            }
        }
    }
}

#[cfg(test)]
impl Place {
    /// A point of a surface that faces `normal`, surveyed to five centimetres, and clicked as surely.
    pub(super) fn on(normal: DVec3, position: DVec3) -> Self {
        let surface = PickedSurface::Point;
        Self { position, normal, uncertainty_m: 0.05, surface, off_m: Some(0.05) }
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn a_click_is_no_surer_than_a_hand_and_less_sure_of_what_is_seen_askew() {
        // A wall 20 m ahead, of which a pixel is 2 cm; seen askew it is more, but never without end.
        let fov_y = 2.0 * (0.5f64 * 480.0 / 1000.0).atan();
        let view = View::look(DVec3::ZERO, 0.0, 0.0, fov_y, UVec2::new(640, 480));
        let off_m = |normal, uncertainty_m| {
            let (position, seen_by) = (DVec3::Y * 20.0, Vec::new());
            let surface = PickedSurface::Mesh(SurfaceClass::Wall);
            Place::met(&view, &Picked { position, normal, uncertainty_m, surface, seen_by }).off_m
        };
        let across_m = 0.03f64.hypot(0.02);
        for (normal, times) in [
            (DVec3::NEG_Y, 1.0),
            (DVec3::new(0.0, -0.2, 0.98), 5.0),
            (DVec3::new(0.99995, -0.01, 0.0), 10.0),
        ] {
            let off_m = off_m(normal, 0.03).expect("known");
            assert!((off_m - times * across_m).abs() < 1e-9, "{off_m}");
        }
        assert_eq!(off_m(DVec3::NEG_Y, 0.0), None);
    }

    #[test]
    fn a_place_is_what_the_survey_says_it_is() {
        let mesh = |class| Place {
            surface: PickedSurface::Mesh(class),
            ..Place::on(DVec3::Z, DVec3::new(0.0, 8.0, 12.0))
        };
        assert_eq!(mesh(SurfaceClass::Ground).kind(None), PlaceKind::Ground);
        assert_eq!(mesh(SurfaceClass::Wall).kind(Some(12.0)), PlaceKind::Wall);
        assert_eq!(mesh(SurfaceClass::Roof).kind(Some(12.0)), PlaceKind::Other);
        let point = |normal: DVec3, ground| {
            Place::on(normal.normalize(), DVec3::new(0.0, 8.0, 12.0)).kind(ground)
        };
        assert_eq!(point(DVec3::NEG_Y, Some(11.9)), PlaceKind::Ground);
        assert_eq!(point(DVec3::NEG_Y, Some(10.0)), PlaceKind::Wall);
        assert_eq!(point(DVec3::Z, Some(4.0)), PlaceKind::Other);
        assert_eq!(point(DVec3::new(0.3, 0.0, 1.0), None), PlaceKind::Ground);
        assert_eq!(point(DVec3::NEG_Z, None), PlaceKind::Other);
    }
}

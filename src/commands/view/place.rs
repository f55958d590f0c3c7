//! Places on surfaces, as one clicks them.

use flaneur_renderer::{Picked, PickedSurface, Sight};
use flaneur_scene::SurfaceClass;
use glam::DVec3;

/// Higher above the terrain a point is not on the ground, metres.
const STEP: f64 = 0.4;
/// Points on surfaces that lean less than this from the upright are on walls, and where the terrain is
/// not known those that lean more than this are on the ground: sines.
const UPRIGHT: f64 = 0.4;
const LEVEL: f64 = 0.7;

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
    /// The photographs that see it, the one that counts most in its colour first.
    pub(super) photographs: Vec<Sight>,
}

/// What one does at a place: go there, face it, or look at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlaceKind {
    Ground,
    Wall,
    Other,
}

impl Place {
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

    /// What was surveyed there, in words.
    pub(super) fn what(&self) -> &'static str {
        match self.surface {
            PickedSurface::Point => "lidar point",
            PickedSurface::Mesh(SurfaceClass::Ground) => "terrain",
            PickedSurface::Mesh(SurfaceClass::Wall) => "wall",
            PickedSurface::Mesh(SurfaceClass::Roof) => "roof",
        }
    }
}

impl From<Picked> for Place {
    fn from(picked: Picked) -> Self {
        Self {
            position: picked.position,
            normal: picked.normal,
            uncertainty_m: picked.uncertainty_m,
            surface: picked.surface,
            photographs: picked.seen_by,
        }
    }
}

#[cfg(test)]
impl Place {
    /// A point of a surface that faces `normal`, surveyed to five centimetres.
    pub(super) fn on(normal: DVec3, position: DVec3) -> Self {
        let surface = PickedSurface::Point;
        Self { position, normal, uncertainty_m: 0.05, surface, photographs: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

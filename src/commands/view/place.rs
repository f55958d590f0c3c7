//! Places on surfaces, as one clicks them.

use std::fmt;

use flaneur_renderer::{Picked, PickedSurface};
use flaneur_scene::SurfaceClass;
use glam::DVec3;

/// Surfaces that lean less than this from the horizontal are ground to stand on: the cosine.
const LEVEL: f64 = 0.7;

/// A place on a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    /// World, metres.
    pub(super) position: DVec3,
    /// Of the surface, towards the eye, a unit vector.
    pub(super) normal: DVec3,
    /// How far the surface may be from there, metres.
    uncertainty_m: f64,
    /// What was surveyed there, and the photograph that counts most in its colour.
    what: &'static str,
    photograph: Option<String>,
}

impl Place {
    /// On a surface that faces `normal`.
    #[cfg(test)]
    pub(super) fn on(normal: DVec3, position: DVec3) -> Self {
        Self { position, normal, uncertainty_m: 0.1, what: "surface", photograph: None }
    }

    /// Whether one can stand there.
    pub(super) fn is_level(&self) -> bool {
        self.normal.z > LEVEL
    }
}

impl From<Picked> for Place {
    fn from(picked: Picked) -> Self {
        let what = match picked.surface {
            PickedSurface::Point => "point",
            PickedSurface::Mesh(SurfaceClass::Ground) => "ground",
            PickedSurface::Mesh(SurfaceClass::Wall) => "wall",
            PickedSurface::Mesh(SurfaceClass::Roof) => "roof",
        };
        Self {
            position: picked.position,
            normal: picked.normal,
            uncertainty_m: picked.uncertainty_m,
            what,
            photograph: picked.seen_by.first().map(|sight| sight.id.to_string()),
        }
    }
}

/// Where it is, how surely, and from what that is known.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (at, uncertainty_m) = (self.position, self.uncertainty_m);
        write!(f, "{:.2}  {:.2}  {:.2}  ± {uncertainty_m:.2} m", at.x, at.y, at.z)?;
        write!(f, "   {}", self.what)?;
        self.photograph.iter().try_for_each(|photograph| write!(f, ", photograph {photograph}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_stands_on_what_is_level() {
        let on = |normal: DVec3| Place::on(normal.normalize(), DVec3::new(1.0, 2.0, 3.0));
        assert!(on(DVec3::Z).is_level() && on(DVec3::new(0.3, 0.0, 1.0)).is_level());
        assert!(!on(DVec3::X).is_level() && !on(DVec3::NEG_Z).is_level());
        assert_eq!(on(DVec3::Z).to_string(), "1.00  2.00  3.00  ± 0.10 m   surface");
    }
}

//! Equirectangular panoramas, as from a camera on someone's shoulders.

use flaneur_scene::world_from_rig;
use glam::{DVec2, DVec3, UVec2};

use super::picture::Sighting;
use super::rig::time_of_day;
use super::{Station, rounded};

/// One spherical exposure, with the very numbers that the list holds.
#[derive(Clone, Debug)]
pub(crate) struct SpherePose {
    /// Its name.
    pub(crate) id: String,
    /// World position.
    pub(crate) position: DVec3,
    /// Clockwise from grid north.
    pub(crate) heading_deg: f64,
    /// Up.
    pub(crate) pitch_deg: f64,
    /// Right side down.
    pub(crate) roll_deg: f64,
    /// Seconds since the survey began.
    pub(crate) seconds: f64,
}

impl SpherePose {
    /// Header of the list.
    pub(crate) const COLUMNS: &str = "id,x,y,z,heading_deg,pitch_deg,roll_deg,image,time";

    /// The pose with its numbers rounded as the list holds them.
    pub(crate) fn rounded(self) -> Self {
        Self {
            position: self.position.map(|x| rounded(x, 3)),
            heading_deg: rounded(self.heading_deg, 4),
            pitch_deg: rounded(self.pitch_deg, 4),
            roll_deg: rounded(self.roll_deg, 4),
            ..self
        }
    }

    /// Its line of the list.
    pub(crate) fn row(&self, image: &str) -> String {
        let p = self.position;
        format!(
            "{},{:.3},{:.3},{:.3},{:.4},{:.4},{:.4},{image},{}",
            self.id,
            p.x,
            p.y,
            p.z,
            self.heading_deg,
            self.pitch_deg,
            self.roll_deg,
            time_of_day(self.seconds)
        )
    }

    /// The lines of sight of an image of `size`, twice as wide as high: the inverse of
    /// [`flaneur_scene::CubeFace::equirectangular_from_rig`]. Depth is distance.
    pub(crate) fn sight(&self, size: UVec2) -> impl Fn(DVec2) -> Option<Sighting> + Sync {
        let [h, p, r] = [self.heading_deg, self.pitch_deg, self.roll_deg].map(f64::to_radians);
        let station = Station::new(self.position, world_from_rig(h, p, r));
        move |pixel| {
            let at = pixel / size.as_dvec2();
            let (sin_azimuth, cos_azimuth) = ((at.x - 0.5) * std::f64::consts::TAU).sin_cos();
            let (sin_elevation, cos_elevation) = ((0.5 - at.y) * std::f64::consts::PI).sin_cos();
            let direction =
                DVec3::new(sin_azimuth * cos_elevation, cos_azimuth * cos_elevation, sin_elevation);
            let ray = station.ray(direction);
            Some(Sighting { ray, depth_per_metre: 1.0, vehicle: None })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::StreetFrame;
    use flaneur_scene::CubeFace;

    /// A line of sight leads back to its pixel through the projection that readers use.
    #[test]
    fn lines_of_sight_lead_back_to_their_pixels() {
        let pose = SpherePose {
            id: "one".to_owned(),
            position: DVec3::new(651_500.0, 6_861_000.0, 40.0),
            heading_deg: 123.0,
            pitch_deg: 4.0,
            roll_deg: -7.0,
            seconds: 0.0,
        };
        let size = UVec2::new(400, 200);
        let sight = pose.sight(size);
        let rotation = world_from_rig(123f64.to_radians(), 4f64.to_radians(), -7f64.to_radians());
        for i in 0..200 {
            let pixel = DVec2::new(1.9 * f64::from(i) + 0.3, 0.99 * f64::from(i) + 0.4);
            let ray = sight(pixel).expect("everywhere").ray;
            let world = StreetFrame::PLACE.world_from_street() * ray.direction;
            let back = CubeFace::equirectangular_from_rig(rotation.transpose() * world, size);
            assert!(back.distance(pixel) < 1e-6, "{pixel} {back}");
        }
    }
}

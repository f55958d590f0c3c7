//! What coordinates refer to.

use flaneur_scene::SceneInfo;
use flaneur_services::crs::Crs;
use glam::DVec3;

/// The reference of a scene.
#[derive(Debug)]
pub(in crate::commands::view) struct Reference {
    /// As the scene has it: `EPSG:code`, or `local`.
    pub(in crate::commands::view) code: String,
    /// Latitude, longitude and height of (0, 0, 0) of a local one.
    geographic_origin: Option<[f64; 3]>,
    crs: Option<Crs>,
}

impl Reference {
    /// That of a scene.
    pub(in crate::commands::view) fn of(info: &SceneInfo) -> Self {
        Self::new(&info.crs, info.geographic_origin)
    }

    pub(super) fn new(code: &str, geographic_origin: Option<[f64; 3]>) -> Self {
        let crs = Crs::parse(code, geographic_origin).ok();
        Self { code: code.to_owned(), geographic_origin, crs }
    }

    /// It in words, with what its axes are.
    pub(super) fn words(&self) -> String {
        let axes = "east, north, height in metres";
        let unnamed = "the survey does not name what heights count from";
        match (self.crs.as_ref().map(Crs::name), self.geographic_origin) {
            // A compound CRS is called by both of its parts.
            (Some(Some(name)), _) if name.contains(" + ") => {
                format!("{name} ({}): {axes}", self.code)
            }
            (Some(Some(name)), _) => format!("{name} ({}): {axes}; {unnamed}", self.code),
            (Some(None), Some([latitude, longitude, _])) => {
                format!(
                    "metres from {latitude:.8}, {longitude:.8} (WGS84), level there (local): {axes}"
                )
            }
            (Some(None), None) => format!("the survey's own metres (local): {axes}"),
            (None, _) => format!("{}: {axes}; {unnamed}", self.code),
        }
    }

    /// Latitude and longitude of a place, degrees; `None` where it is not tied to the Earth.
    pub(super) fn geographic(&self, place: DVec3) -> Option<[f64; 2]> {
        let [latitude, longitude, _] = self.crs.as_ref()?.to_wgs84(place).ok()?;
        Some([latitude, longitude])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_has_a_name_and_axes_and_says_where_on_earth_a_place_is() {
        let lambert = Reference::new("EPSG:2154", None);
        assert!(lambert.words().starts_with("RGF93 / Lambert-93 (EPSG:2154): east, north"));
        assert!(lambert.words().ends_with("what heights count from"));
        let place = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        let [latitude, longitude] = lambert.geographic(place).expect("on Earth");
        assert!((48.8..48.9).contains(&latitude) && (2.3..2.4).contains(&longitude));
        let dutch = Reference::new("EPSG:7415", None).words();
        assert!(dutch.ends_with("(EPSG:7415): east, north, height in metres"), "{dutch}");
        let here = Reference::new("local", Some([49.0, 8.4, 112.0]));
        assert!(here.words().starts_with("metres from 49.00000000, 8.40000000 (WGS84)"));
        let at = here.geographic(DVec3::ZERO).expect("on Earth");
        assert!((at[0] - 49.0).abs() < 1e-9 && (at[1] - 8.4).abs() < 1e-9, "{at:?}");
        let nowhere = Reference::new("local", None);
        assert!(nowhere.words().starts_with("the survey's own metres (local)"));
        assert_eq!(nowhere.geographic(place), None);
    }
}

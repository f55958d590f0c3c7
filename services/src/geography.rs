//! Where on Earth the places of a scene are.

use flaneur_proto::v1;
use flaneur_scene::SceneInfo;
use glam::DVec3;

use crate::crs::Crs;

/// Half the step of the central differences of [`frame`], metres.
const STEP_M: f64 = 50.0;

/// Geographic position (WGS84) of a place of the scene, world, metres; `None` where the scene's CRS
/// is not tied to the Earth, or does not reach there.
pub(crate) fn position(scene: &SceneInfo, place: DVec3) -> Option<v1::GeographicPosition> {
    let crs = Crs::parse(&scene.crs, scene.geographic_origin).ok()?;
    let [latitude_deg, longitude_deg, height_m] = crs.to_wgs84(place).ok()?;
    Some(v1::GeographicPosition { latitude_deg, longitude_deg, height_m })
}

/// What people call the scene's CRS; empty where it has no name.
pub(crate) fn crs_name(scene: &SceneInfo) -> String {
    let crs = Crs::parse(&scene.crs, scene.geographic_origin).ok();
    crs.and_then(|crs| crs.name()).unwrap_or_default().to_owned()
}

/// The same around the scene's origin, to first order: position and central differences.
pub(crate) fn frame(scene: &SceneInfo) -> Option<v1::GeographicFrame> {
    let derivative = |axis: DVec3| {
        let ahead = position(scene, scene.origin + STEP_M * axis)?;
        let behind = position(scene, scene.origin - STEP_M * axis)?;
        let rate = |ahead: f64, behind: f64| (ahead - behind) / (2.0 * STEP_M);
        Some((
            rate(ahead.longitude_deg, behind.longitude_deg),
            rate(ahead.latitude_deg, behind.latitude_deg),
        ))
    };
    let ((longitude_x, latitude_x), (longitude_y, latitude_y)) =
        (derivative(DVec3::X)?, derivative(DVec3::Y)?);
    Some(v1::GeographicFrame {
        origin: Some(position(scene, scene.origin)?),
        longitude_per_m: Some(v1::Point2 { x: longitude_x, y: longitude_y }),
        latitude_per_m: Some(v1::Point2 { x: latitude_x, y: latitude_y }),
    })
}

#[cfg(test)]
mod tests {
    use flaneur_scene::Bounds3;

    use super::*;

    fn scene(crs: &str, origin: DVec3) -> SceneInfo {
        SceneInfo {
            name: "street".to_owned(),
            crs: crs.to_owned(),
            geographic_origin: None,
            origin,
            bounds: Bounds3 { min: origin, max: origin },
            footprints: 0,
            panoramas: 0,
            images: 0,
            ground: None,
            point_sources: Vec::new(),
            version: "1".to_owned(),
        }
    }

    #[test]
    fn to_first_order_a_kilometre_is_right_to_half_a_metre() {
        let origin = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        let scene = scene("EPSG:2154", origin);
        let frame = frame(&scene).expect("on Earth");
        let (at, longitude, latitude) = (
            frame.origin.expect("there"),
            frame.longitude_per_m.expect("there"),
            frame.latitude_per_m.expect("there"),
        );
        for step in [DVec3::X * 1e3, DVec3::Y * -1e3, DVec3::new(700.0, 700.0, 0.0)] {
            let exact = position(&scene, origin + step).expect("on Earth");
            let east = at.longitude_deg + longitude.x * step.x + longitude.y * step.y;
            let north = at.latitude_deg + latitude.x * step.x + latitude.y * step.y;
            // Metres for a degree, there.
            let error_m = f64::hypot(
                (east - exact.longitude_deg) * 73_200.0,
                (north - exact.latitude_deg) * 111_200.0,
            );
            assert!(error_m < 0.5, "{error_m} m after {step}");
        }
    }

    #[test]
    fn people_have_names_for_crs() {
        let name = |crs| crs_name(&scene(crs, DVec3::ZERO));
        assert_eq!(name("EPSG:2154"), "RGF93 / Lambert-93");
        assert_eq!(name("EPSG:28992"), "Amersfoort / RD New");
        assert_eq!(name("EPSG:7415"), "Amersfoort / RD New + NAP height");
        assert_eq!((name("local"), name("EPSG:1")), (String::new(), String::new()));
    }

    #[test]
    fn metres_alone_are_nowhere_on_earth() {
        assert_eq!(frame(&scene("local", DVec3::ZERO)), None);
    }
}

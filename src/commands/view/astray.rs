//! Who sees nothing of a scene: the web page's rule, see services/web/src/panels/astray.ts.

use flaneur_scene::{Bounds3, View, ViewProjection};
use flaneur_services::shares::Shares;
use glam::DVec2;

/// Less of a picture is next to nothing.
const NEXT_TO_NOTHING: f64 = 0.001;
/// So far outside of a scene the sky alone is no view of it, metres.
const OUTSIDE_M: f64 = 100.0;

/// Whether a picture shows next to nothing of a scene; who stands in a street may look at the sky, even at one that no
/// photograph shows.
pub(super) fn is_astray(shares: Shares, view: &View, bounds: &Bounds3) -> bool {
    let eye = view.eye();
    let near = || {
        let (min, max) = (bounds.min - OUTSIDE_M, bounds.max + OUTSIDE_M);
        bounds.is_empty() || eye.cmpgt(min).all() && eye.cmplt(max).all()
    };
    let mostly = 1.0 - NEXT_TO_NOTHING;
    shares.unsurveyed > mostly && (!near() || shares.blank > mostly && !is_of_sky(view))
}

/// Whether all of a picture lies above the horizon.
fn is_of_sky(view: &View) -> bool {
    let size = view.size().as_dvec2();
    let lowest = view.ray(size * DVec2::new(0.5, 1.0));
    view.projection == ViewProjection::Perspective
        && lowest.is_some_and(|ray| ray.direction.z > 0.0)
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, UVec2};
    use serde_json::Value;

    use super::*;

    /// Those of the page, too.
    const CASES: &str = include_str!("../../../services/web/src/panels/astray.cases.json");

    #[test]
    fn one_is_astray_where_one_is_on_the_page() {
        let cases: Value = serde_json::from_str(CASES).expect("JSON");
        let number = |value: &Value| value.as_f64().expect("a number");
        let vector = |value: &Value| DVec3::from([0, 1, 2].map(|axis| number(&value[axis])));
        let bounds = &cases["bounds"];
        let bounds = Bounds3 { min: vector(&bounds["min"]), max: vector(&bounds["max"]) };
        let frames = cases["frames"].as_array().expect("frames");
        assert!(frames.len() > 5);
        for case in frames {
            let (unsurveyed, blank) = (number(&case["unsurveyed"]), number(&case["blank"]));
            let view = looking(vector(&case["eye"]), case["pitch"].as_f64().unwrap_or(0.0));
            let astray = is_astray(Shares { unsurveyed, blank }, &view, &bounds);
            assert_eq!(astray, case["astray"] == true, "{}", case["what"]);
        }
        let sky = Shares { unsurveyed: 1.0, blank: 0.0 };
        let far = looking(DVec3::splat(1e6), 0.0);
        assert!(!is_astray(sky, &far, &Bounds3::EMPTY), "nobody knows where it is");
    }

    /// A pitch in degrees.
    fn looking(eye: DVec3, pitch: f64) -> View {
        View::look(eye, 1.0, pitch.to_radians(), 60f64.to_radians(), UVec2::new(1024, 512))
    }
}

//! Someone who walks down the street and back, and looks around.

use glam::DVec3;
use serde_json::{Value, json};

use super::rounded;
use crate::frame::StreetFrame;
use crate::street::Street;

/// Height of the eye above the ground, metres.
const EYE_M: f64 = 1.65;
/// Distance from the axis, to the right of the way that is walked: between the parked cars.
const ASIDE_M: f64 = 0.9;
/// Distance from the block's ends at which one sets out and turns round.
const MARGIN_M: f64 = 6.0;
/// Between two views: where the slope changes.
const STEP_M: f64 = 4.0;
/// How far one looks to either side, degrees, and over which length from side to side and back, metres.
const GLANCE: (f64, f64) = (24.0, 35.0);
const PITCH_DEG: f64 = 3.0;

/// The views of a walk along the whole block and back, in the order in which they are reached.
pub(crate) fn there_and_back(street: &Street) -> Value {
    let frame = StreetFrame::PLACE;
    let way_m = street.length_m - 2.0 * MARGIN_M;
    let steps = (way_m / STEP_M).ceil().max(1.0) as u32;
    let view = |step: u32, back: bool| {
        let walked = way_m * f64::from(step) / f64::from(steps);
        let (x, y, turn) = if back {
            (street.length_m - MARGIN_M - walked, ASIDE_M, 180.0)
        } else {
            (MARGIN_M + walked, -ASIDE_M, 0.0)
        };
        let eye = DVec3::new(x, y, street.terrain.height(x, y) + EYE_M);
        let (aside, length_m) = GLANCE;
        let glance = aside * (std::f64::consts::TAU * walked / length_m).sin();
        let heading = frame.heading().to_degrees() + turn + glance;
        json!({
            "position": frame.world_from_point(eye).map(|x| rounded(x, 3)).to_array(),
            "heading_deg": rounded(heading.rem_euclid(360.0), 2),
            "pitch_deg": PITCH_DEG,
        })
    };
    let both = [false, true].into_iter();
    both.flat_map(|back| (0..=steps).map(move |step| view(step, back))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ray;

    #[test]
    fn nothing_is_in_the_way() {
        for length_m in [20.0, 120.0] {
            let street = Street::new(1, length_m);
            let frame = StreetFrame::PLACE;
            let walk = there_and_back(&street);
            let eyes: Vec<DVec3> = walk
                .as_array()
                .expect("a list")
                .iter()
                .map(|view| {
                    let at = |axis: usize| view["position"][axis].as_f64().expect("a number");
                    frame.point_from_world(DVec3::new(at(0), at(1), at(2)))
                })
                .collect();
            assert!(eyes.len() >= 4 && eyes.len().is_multiple_of(2));
            for pair in eyes.windows(2) {
                let way = pair[1] - pair[0];
                assert!(way.length() > 0.5 && way.length() < 5.0, "{pair:?}");
                let ray = Ray { origin: pair[0], direction: way.normalize() };
                assert!(!street.tree.is_blocked(&ray, way.length()), "{pair:?}");
                let ground = street.terrain.height(pair[0].x, pair[0].y);
                assert!((pair[0].z - ground - EYE_M).abs() < 0.01);
            }
            assert!(eyes[0].distance(eyes[eyes.len() - 1]) < 2.0 * ASIDE_M + 0.1, "back again");
        }
    }
}

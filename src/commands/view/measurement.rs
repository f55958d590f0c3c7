//! What lies between two places, and how it is written: as the web page does.

use glam::DVec3;

use super::place::Place;

/// What lies between two places, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measurement {
    pub(super) distance: f64,
    pub(super) horizontal: f64,
    /// Up from the first to the second.
    pub(super) vertical: f64,
    /// One standard deviation of the distance; `None` where that of a place is unknown.
    pub(super) uncertainty: Option<f64>,
}

impl Measurement {
    /// From one place to another.
    pub(super) fn between(from: &Place, to: &Place) -> Self {
        let way = to.position - from.position;
        let known = from.uncertainty_m > 0.0 && to.uncertainty_m > 0.0;
        Self {
            distance: way.length(),
            horizontal: way.truncate().length(),
            vertical: way.z,
            // Places are surveyed apart from each other.
            uncertainty: known.then(|| from.uncertainty_m.hypot(to.uncertainty_m)),
        }
    }
}

/// Millimetres are the survey's own; more is noise.
pub(super) fn metres(value: f64) -> String {
    format!("{value:.3} m")
}

/// With its sign, as heights differ.
pub(super) fn signed_metres(value: f64) -> String {
    format!("{}{:.3} m", if value < 0.0 { '\u{2212}' } else { '+' }, value.abs())
}

/// Uncertainties to two digits that matter.
pub(super) fn plus_minus(value: f64) -> String {
    match value {
        ..0.1 => format!("± {:.0} mm", value * 1e3),
        ..1.0 => format!("± {:.0} cm", value * 1e2),
        _ => format!("± {value:.1} m"),
    }
}

/// East, north and height.
pub(super) fn coordinates(place: DVec3) -> String {
    format!("{:.3}, {:.3}, {:.3}", place.x, place.y, place.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_has_its_parts_and_the_uncertainty_of_both_ends() {
        let at = |position, uncertainty_m| Place { uncertainty_m, ..Place::on(DVec3::Z, position) };
        let from = at(DVec3::new(651_000.0, 6_861_000.0, 50.0), 0.03);
        let to = at(DVec3::new(651_003.0, 6_861_004.0, 38.0), 0.04);
        let measured = Measurement::between(&from, &to);
        let parts = [measured.distance, measured.horizontal, measured.vertical];
        assert_eq!(parts, [13.0, 5.0, -12.0]);
        assert!((measured.uncertainty.expect("known") - 0.05).abs() < 1e-12);
        assert_eq!(Measurement::between(&from, &at(to.position, 0.0)).uncertainty, None);
    }

    #[test]
    fn lengths_are_written_to_the_millimetre() {
        assert_eq!(metres(1.23456), "1.235 m");
        assert_eq!([-0.5, 0.5].map(signed_metres), ["\u{2212}0.500 m", "+0.500 m"]);
        assert_eq!([0.012, 0.25, 2.345].map(plus_minus), ["± 12 mm", "± 25 cm", "± 2.3 m"]);
        let place = DVec3::new(651_507.5, 6_861_077.123_45, -4.0);
        assert_eq!(coordinates(place), "651507.500, 6861077.123, -4.000");
    }
}

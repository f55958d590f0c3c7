//! What lies between two places, and how it is written: as the web page does.

use glam::DVec3;

use super::place::Place;

/// From here on millimetres mean nothing, metres.
const COARSE_M: f64 = 0.1;
/// Metres of a degree of latitude.
const DEGREE_M: f64 = 111_320.0;

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
        Self {
            distance: way.length(),
            horizontal: way.truncate().length(),
            vertical: way.z,
            // Places are surveyed apart from each other, and so are they clicked.
            uncertainty: from.off_m.zip(to.off_m).map(|(from, to)| from.hypot(to)),
        }
    }
}

/// Millimetres are the survey's own; more is noise. Centimetres where it is `sure` of decimetres alone.
pub(super) fn metres(value: f64, sure: Option<f64>) -> String {
    format!("{value:.*} m", digits(sure))
}

fn digits(sure: Option<f64>) -> usize {
    if sure.is_some_and(|sure| sure >= COARSE_M) { 2 } else { 3 }
}

/// A length to read in passing.
pub(super) fn rough_metres(value: f64) -> String {
    if value < 10.0 { format!("{value:.1} m") } else { format!("{value:.0} m") }
}

/// With its sign, as heights differ.
pub(super) fn signed_metres(value: f64, sure: Option<f64>) -> String {
    format!("{}{}", if value < 0.0 { '\u{2212}' } else { '+' }, metres(value.abs(), sure))
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
pub(super) fn coordinates(place: DVec3, sure: Option<f64>) -> String {
    place.to_array().map(|value| format!("{value:.*}", digits(sure))).join(", ")
}

/// Latitude and longitude: the last digit is about a third of what they are sure of, a centimetre where
/// that is unknown (0).
pub(super) fn geographic([latitude, longitude]: [f64; 2], sure: f64) -> String {
    let third = if sure > 0.0 { sure / 3.0 } else { 0.01 };
    let places = (DEGREE_M / third).log10().round().clamp(4.0, 8.0) as usize;
    format!("{latitude:.places$}, {longitude:.places$}")
}

/// The day and minute of an RFC 3339 time, as they stand there, and its zone.
pub(super) fn date(time: Option<&str>) -> String {
    let Some(time) = time.filter(|time| !time.is_empty()) else { return "undated".to_owned() };
    let zone = time.get(time.len().saturating_sub(6)..).filter(|zone| {
        let of_hours = zone.starts_with(['+', '-']) && zone.as_bytes().get(3) == Some(&b':');
        of_hours && !zone.ends_with("00:00")
    });
    let minute = time.get(..16).unwrap_or(time).replacen('T', " ", 1);
    format!("{minute} {}", zone.unwrap_or("UTC"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_has_its_parts_and_the_uncertainty_of_both_ends() {
        let at = |position, off_m| Place { off_m, ..Place::on(DVec3::Z, position) };
        let from = at(DVec3::new(651_000.0, 6_861_000.0, 50.0), Some(0.03));
        let to = at(DVec3::new(651_003.0, 6_861_004.0, 38.0), Some(0.04));
        let measured = Measurement::between(&from, &to);
        let parts = [measured.distance, measured.horizontal, measured.vertical];
        assert_eq!(parts, [13.0, 5.0, -12.0]);
        assert!((measured.uncertainty.expect("known") - 0.05).abs() < 1e-12);
        assert_eq!(Measurement::between(&from, &at(to.position, None)).uncertainty, None);
    }

    #[test]
    fn lengths_are_written_to_the_millimetre_where_the_survey_is_as_sure() {
        assert_eq!([None, Some(0.5)].map(|sure| metres(1.23456, sure)), ["1.235 m", "1.23 m"]);
        let signed = [-0.5, 0.5].map(|value| signed_metres(value, None));
        assert_eq!(signed, ["\u{2212}0.500 m", "+0.500 m"]);
        assert_eq!([9.94, 12.4].map(rough_metres), ["9.9 m", "12 m"]);
        assert_eq!([0.012, 0.25, 2.345].map(plus_minus), ["± 12 mm", "± 25 cm", "± 2.3 m"]);
        let place = DVec3::new(651_507.5, 6_861_077.123_45, -4.0);
        assert_eq!(coordinates(place, Some(0.05)), "651507.500, 6861077.123, -4.000");
        assert_eq!(coordinates(DVec3::new(1.0, 2.0, 4.56789), Some(0.25)), "1.00, 2.00, 4.57");
    }

    #[test]
    fn degrees_have_no_more_digits_than_the_survey_is_sure_of() {
        let at = [48.123_456_789, 2.1];
        assert_eq!(geographic(at, 0.5), "48.123457, 2.100000");
        assert_eq!(geographic(at, 0.03), "48.1234568, 2.1000000");
        assert_eq!(geographic(at, 0.0), "48.1234568, 2.1000000");
    }

    #[test]
    fn dates_are_said_to_the_minute_with_their_zone() {
        assert_eq!(date(Some("2024-05-14T09:06:40.125Z")), "2024-05-14 09:06 UTC");
        assert_eq!(date(Some("2024-05-14T09:06:40+00:00")), "2024-05-14 09:06 UTC");
        assert_eq!(date(Some("2024-05-14T09:06:40-05:30")), "2024-05-14 09:06 -05:30");
        assert_eq!([None, Some("")].map(date), ["undated", "undated"]);
    }
}

//! What is said of measured places: where they are, from what they are known, what lies between them.

use flaneur_services::crs::Crs;

use crate::commands::view::measurement::{coordinates, metres, plus_minus, signed_metres};
use crate::commands::view::measuring::Measuring;
use crate::commands::view::place::Place;

const INTRODUCTION: &str = "Click a place for its coordinates, a second one for the distance.";

/// What coordinates refer to.
#[derive(Debug)]
pub(in crate::commands::view) struct Reference {
    /// As the scene has it: `EPSG:code`, or `local`.
    pub(in crate::commands::view) crs: String,
    /// Latitude, longitude and height of (0, 0, 0) of a local one.
    pub(in crate::commands::view) geographic_origin: Option<[f64; 3]>,
}

impl Reference {
    /// It in words.
    fn words(&self) -> String {
        let crs = Crs::parse(&self.crs, self.geographic_origin).ok();
        match (crs.as_ref().map(Crs::name), self.geographic_origin) {
            (Some(Some(name)), _) => format!("{name} ({})", self.crs),
            (Some(None), Some([latitude, longitude, _])) => {
                format!("metres from {latitude:.7}, {longitude:.7} (WGS84), level there (local)")
            }
            (Some(None), None) => "the survey's own metres (local)".to_owned(),
            (None, _) => self.crs.clone(),
        }
    }

    /// Latitude and longitude of a place, degrees, where it is tied to the Earth.
    fn geographic(&self, place: &Place) -> Option<String> {
        let crs = Crs::parse(&self.crs, self.geographic_origin).ok()?;
        let [latitude, longitude, _] = crs.to_wgs84(place.position).ok()?;
        // A centimetre.
        Some(format!("{latitude:.7}, {longitude:.7}"))
    }
}

/// A line for each thing that is to be said.
pub(super) fn lines(measuring: &Measuring, reference: &Reference) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(measured) = measuring.measurement() {
        let sure = measured.uncertainty.map(plus_minus).unwrap_or_default();
        let (horizontal, vertical) =
            (metres(measured.horizontal), signed_metres(measured.vertical));
        lines.push(format!("Distance {} {sure}", metres(measured.distance)));
        lines.push(format!("horizontal {horizontal}, vertical {vertical}"));
    }
    for (place, letter) in measuring.places().iter().zip(["A", "B"]) {
        let unsure = match place.uncertainty_m {
            known if known > 0.0 => plus_minus(known),
            _ => "of unknown uncertainty".to_owned(),
        };
        lines.push(format!("{letter}  {} {unsure}", coordinates(place.position)));
        let wgs84 = reference.geographic(place).map(|at| format!("WGS84 {at}"));
        lines.extend(wgs84.map(|at| format!("     {at}")));
        let seen = match place.photographs.first() {
            Some(sight) => format!("photograph {}", sight.id),
            None => "no photograph sees it".to_owned(),
        };
        lines.push(format!("     {}, {seen}", place.what()));
    }
    if !measuring.places().is_empty() {
        lines.push(format!("{}: east, north, height in metres", reference.words()));
    }
    if measuring.asks() {
        lines.push("Asking ...".to_owned());
    } else if measuring.places().is_empty() {
        lines.push(INTRODUCTION.to_owned());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_tape_says_where_its_ends_are_and_what_lies_between() {
        let reference = Reference { crs: "EPSG:2154".to_owned(), geographic_origin: None };
        let mut tape = Measuring::default();
        tape.toggle();
        assert_eq!(lines(&tape, &reference), [INTRODUCTION]);
        let from = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        for place in [from, from + DVec3::new(3.0, 4.0, -12.0)] {
            let round = tape.ask();
            assert_eq!(lines(&tape, &reference).last().map(String::as_str), Some("Asking ..."));
            tape.take(round, Some(Place::on(DVec3::Z, place)));
        }
        let said = lines(&tape, &reference);
        assert_eq!(said[0], "Distance 13.000 m ± 71 mm");
        assert_eq!(said[1], "horizontal 5.000 m, vertical \u{2212}12.000 m");
        assert_eq!(said[2], "A  651000.000, 6861000.000, 40.000 ± 50 mm");
        assert!(
            said[3].starts_with("     WGS84 48.84") && said[4].contains("lidar point"),
            "{said:?}"
        );
        assert!(said[8].contains("Lambert-93") && said[8].contains("EPSG:2154"), "{said:?}");
        let nowhere = Reference { crs: "local".to_owned(), geographic_origin: None };
        let places =
            lines(&tape, &Reference { geographic_origin: Some([49.0, 8.4, 112.0]), ..nowhere });
        assert!(places[8].starts_with("metres from 49.0000000, 8.4000000"), "{places:?}");
        let nowhere = Reference { crs: "local".to_owned(), geographic_origin: None };
        assert!(lines(&tape, &nowhere).iter().all(|line| !line.contains("WGS84")));
    }
}

//! What is said of measured places: where they are, from what they are known, what lies between them.

mod las_class;
mod moment;
mod reference;

use egui::{Align2, Color32, RichText, TextWrapMode};
use flaneur_renderer::PickedSurface;
use flaneur_scene::SurfaceClass;
use flaneur_services::place::Record;

use super::panels::{self, inward};
use crate::commands::view::measurement::{
    coordinates, date, geographic, metres, plus_minus, signed_metres,
};
use crate::commands::view::measuring::{Marked, Measuring, Stored};
use las_class::las_class;
use moment::moment;
pub(in crate::commands::view) use reference::Reference;

const INTRODUCTION: &str = "Click a place for its coordinates, a second one for the distance.";
const ASKING: &str = "Asking ...";

/// It takes at most so much of the window's height.
const SHARE: f32 = 0.5;
/// Widths of what is said, and of the names of figures, points.
const WIDTH: f32 = 330.0;
const NAMES: f32 = 100.0;
/// Where figures have less room beside their names, they stand below them, points.
const LEAST: f32 = 300.0;
/// Height of its letters, and of those of remarks, points.
const LETTERS: f32 = 13.0;
const SMALL: f32 = 11.5;
/// Of remarks and names.
const FAINT: Color32 = Color32::from_gray(175);

/// Something that is said.
#[derive(Clone, Debug, PartialEq)]
enum Line {
    /// Of what the following is.
    Head(&'static str),
    /// A figure by its name.
    Figure(&'static str, String),
    /// Coordinates by their name, which can be copied, and how sure they are.
    Coordinates(&'static str, String, String),
    /// What is to be known of the figure above.
    Remark(String),
    /// Of no figure.
    Note(String),
}

/// Shows it in a corner, above where one clicks: the ground is below.
pub(super) fn show(context: &egui::Context, measuring: &Measuring, reference: &Reference) {
    let side = Align2::RIGHT_TOP;
    let highest = SHARE * context.content_rect().height();
    let frame = egui::Frame::popup(&context.global_style());
    let beside = 2.0 * panels::MARGIN + frame.total_margin().sum().x;
    let widest = context.content_rect().width() - beside;
    let area = egui::Area::new(egui::Id::unique("tape")).anchor(side, inward(side));
    area.show(context, |ui| {
        frame.show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            // What is worth copying has a button for it.
            ui.style_mut().interaction.selectable_labels = false;
            panels::list(highest).show(ui, |ui| {
                ui.set_max_width(widest.min(NAMES + WIDTH));
                for line in lines(measuring, reference) {
                    write(ui, &line);
                }
            });
        });
    });
}

/// Writes a line.
fn write(ui: &mut egui::Ui, line: &Line) {
    let wrapped = |text| egui::Label::new(text).wrap_mode(TextWrapMode::Wrap);
    let letters = |text: &str| RichText::new(text).size(LETTERS);
    let faint = |text: &str| RichText::new(text).size(SMALL).color(FAINT);
    match line {
        Line::Head(head) => _ = ui.strong(*head),
        Line::Note(note) => _ = ui.add(wrapped(faint(note))),
        Line::Figure(name, figure) => {
            beside(ui, letters(name).color(FAINT), |ui| ui.add(wrapped(letters(figure))));
        }
        Line::Remark(remark) => {
            beside(ui, letters(""), |ui| ui.add(wrapped(faint(remark))));
        }
        Line::Coordinates(name, text, about) => {
            let button = egui::Button::new(RichText::new("Copy").size(SMALL)).small();
            let button = beside(ui, letters(name).color(FAINT), |ui| {
                ui.label(letters(&format!("{text} {about}")));
                ui.add(button)
            });
            if button.clicked() {
                ui.ctx().copy_text(text.clone());
            }
        }
    }
}

/// Something beside its name, in narrow windows below it.
fn beside(
    ui: &mut egui::Ui,
    name: RichText,
    add: impl FnOnce(&mut egui::Ui) -> egui::Response,
) -> egui::Response {
    if ui.available_width() < NAMES + LEAST {
        if !name.is_empty() {
            ui.label(name);
        }
        return ui.horizontal_top(add).inner;
    }
    let row = ui.horizontal_top(|ui| {
        ui.allocate_ui(egui::vec2(NAMES, 0.0), |ui| {
            ui.set_min_width(NAMES);
            ui.label(name);
        });
        add(ui)
    });
    row.inner
}

/// All that is to be said.
fn lines(measuring: &Measuring, reference: &Reference) -> Vec<Line> {
    let (mut lines, places) = (Vec::new(), measuring.places());
    if let Some(measured) = measuring.measurement() {
        let sure = measured.uncertainty;
        let about = sure.map(plus_minus).unwrap_or_default();
        let distance = format!("{} {about}", metres(measured.distance, sure));
        lines.push(Line::Figure("Distance", distance.trim_end().to_owned()));
        let horizontal = metres(measured.horizontal, sure);
        let vertical = signed_metres(measured.vertical, sure);
        lines.push(Line::Remark(format!("horizontal {horizontal} · vertical {vertical}")));
    }
    for (marked, head) in places.iter().zip(["Place A", "Place B"]) {
        if places.len() > 1 {
            lines.push(Line::Head(head));
        }
        say_where(&mut lines, marked, reference);
        if let Stored::Known(record) = &marked.stored {
            say_what(&mut lines, marked, record);
        }
    }
    if !places.is_empty() {
        lines.push(Line::Note(reference.words()));
    }
    if measuring.asks() {
        lines.push(Line::Note(ASKING.to_owned()));
    } else if places.is_empty() {
        lines.push(Line::Note(INTRODUCTION.to_owned()));
    }
    lines
}

/// Where a place is, and how surely.
fn say_where(lines: &mut Vec<Line>, Marked { place, .. }: &Marked, reference: &Reference) {
    let unsure = place.uncertainty_m;
    let about = match unsure {
        known if known > 0.0 => plus_minus(known),
        _ => "of unknown uncertainty".to_owned(),
    };
    let position = coordinates(place.position, Some(unsure));
    lines.push(Line::Coordinates("Position", position, about));
    lines.push(match reference.geographic(place.position) {
        Some(degrees) => Line::Coordinates("WGS84", geographic(degrees, unsure), String::new()),
        None => Line::Figure("WGS84", "not tied to the Earth".to_owned()),
    });
}

/// From what it is known.
fn say_what(lines: &mut Vec<Line>, Marked { place, .. }: &Marked, record: &Record) {
    let building = record.footprint.as_deref().unwrap_or_default();
    let mesh = match (place.surface, &record.point) {
        (PickedSurface::Point, Some(point)) => {
            let (source, class) = (&point.source, las_class(point.class));
            let what = format!("lidar point of source {source}: {class}");
            lines.push(Line::Figure("Measured on", what));
            lines.push(Line::Figure("Point as stored", coordinates(point.position, None)));
            let [time, remark] = moment(point);
            lines.push(Line::Figure("Measured at", time));
            lines.extend((!remark.is_empty()).then_some(Line::Remark(remark)));
            None
        }
        (PickedSurface::Point, None) => None,
        (PickedSurface::Mesh(SurfaceClass::Ground), _) => Some("terrain".to_owned()),
        (PickedSurface::Mesh(SurfaceClass::Wall), _) => {
            Some(format!("wall of building {building}"))
        }
        (PickedSurface::Mesh(SurfaceClass::Roof), _) => {
            Some(format!("roof of building {building}"))
        }
    };
    lines.extend(mesh.map(|what| Line::Figure("Measured on", what)));
    let coloured = match record.photographs.first() {
        Some(first) => {
            format!("{}/{}, {}", first.panorama, first.camera, date(first.time.as_deref()))
        }
        None => "none sees it".to_owned(),
    };
    lines.push(Line::Figure("Photograph", coloured));
}

#[cfg(test)]
mod tests {
    use flaneur_scene::GpsTimeKind;
    use flaneur_services::place::StoredSight;
    use flaneur_streamer::SurveyedPoint;
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::commands::view::place::Place;

    /// The figure of a name, of each place that has one.
    fn figures(lines: &[Line], of: &str) -> Vec<String> {
        let figure = |line: &Line| match line {
            Line::Figure(name, figure) if *name == of => Some(figure.clone()),
            Line::Coordinates(name, text, about) if *name == of => {
                Some(format!("{text} {about}").trim_end().to_owned())
            }
            _ => None,
        };
        lines.iter().filter_map(figure).collect()
    }

    /// A tape with a place.
    fn marked(place: Place, record: Record) -> Measuring {
        let mut tape = Measuring::default();
        tape.toggle();
        let round = tape.ask();
        let number = tape.take(round, Some(place)).expect("marked");
        tape.learn(number, Stored::Known(Box::new(record)));
        tape
    }

    #[test]
    fn a_tape_says_where_its_ends_are_and_what_lies_between() {
        let reference = Reference::new("EPSG:2154", None);
        let mut tape = Measuring::default();
        tape.toggle();
        let note = |text: &str| Some(Line::Note(text.to_owned()));
        assert_eq!(lines(&tape, &reference), [Line::Note(INTRODUCTION.to_owned())]);
        let from = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        for place in [from, from + DVec3::new(3.0, 4.0, -12.0)] {
            let round = tape.ask();
            assert_eq!(lines(&tape, &reference).last().cloned(), note(ASKING));
            tape.take(round, Some(Place::on(DVec3::Z, place)));
        }
        let said = lines(&tape, &reference);
        assert_eq!(figures(&said, "Distance"), ["13.000 m ± 71 mm"]);
        let parts = "horizontal 5.000 m · vertical \u{2212}12.000 m";
        assert_eq!(said[1], Line::Remark(parts.to_owned()));
        assert_eq!(figures(&said, "Position")[0], "651000.000, 6861000.000, 40.000 ± 50 mm");
        assert!(figures(&said, "WGS84")[1].starts_with("48.84"), "{said:?}");
        assert!(figures(&said, "Measured on").is_empty(), "that is not known yet: {said:?}");
        assert_eq!(said.last().cloned(), note(ASKING));
        let nowhere = lines(&tape, &Reference::new("local", None));
        assert_eq!(figures(&nowhere, "WGS84"), ["not tied to the Earth"; 2]);
    }

    #[test]
    fn a_point_is_said_as_it_was_surveyed_and_photographs_with_their_time() {
        let place = Place::on(DVec3::Z, DVec3::new(651_000.0, 6_861_000.0, 40.0));
        let point = SurveyedPoint {
            source: "lidar".to_owned(),
            position: DVec3::new(651_000.01, 6_861_000.002, 39.998),
            class: 2,
            intensity: 9,
            gps_time_s: 399_712_818.125,
            gps_time_kind: GpsTimeKind::Adjusted,
        };
        let sight = StoredSight {
            panorama: "7".to_owned(),
            camera: "left".to_owned(),
            time: Some("2024-05-14T09:06:41Z".to_owned()),
            centre: DVec3::ZERO,
            pixel: DVec2::ZERO,
            distance_m: 4.0,
            share: 1.0,
        };
        let record = Record { point: Some(point), footprint: None, photographs: vec![sight] };
        let said = lines(&marked(place, record), &Reference::new("EPSG:2154", None));
        assert_eq!(figures(&said, "Measured on"), ["lidar point of source lidar: ground, class 2"]);
        assert_eq!(figures(&said, "Point as stored"), ["651000.010, 6861000.002, 39.998"]);
        assert_eq!(figures(&said, "Measured at"), ["2024-05-14 09:06:40.125 UTC"]);
        assert_eq!(figures(&said, "Photograph"), ["7/left, 2024-05-14 09:06 UTC"]);
        assert!(!said.contains(&Line::Head("Place A")), "there is no other");
    }

    #[test]
    fn coordinates_can_be_copied_without_what_is_said_of_them() {
        let place = Place::on(DVec3::Z, DVec3::new(651_000.0, 6_861_000.0, 40.0));
        let (tape, reference) =
            (marked(place, Record::default()), Reference::new("EPSG:2154", None));
        let context = egui::Context::default();
        // What is copied where someone does that.
        let after = |events: Vec<egui::Event>| {
            let size = egui::vec2(800.0, 600.0);
            let screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size));
            let input = egui::RawInput { screen_rect, events, ..egui::RawInput::default() };
            let mut copied = None;
            let mut output = context.run_ui(input, |ui| {
                show(ui.ctx(), &tape, &reference);
                copied = panels::copied(ui.ctx());
            });
            output.textures_delta.clear();
            copied
        };
        // A hand goes over all of it.
        let mut copied = std::collections::BTreeSet::new();
        for x in (350..800).step_by(8) {
            for y in (10..120).step_by(4) {
                let pos = egui::pos2(x as f32, y as f32);
                let button = |pressed| egui::Event::PointerButton {
                    pos,
                    button: egui::PointerButton::Primary,
                    pressed,
                    modifiers: egui::Modifiers::NONE,
                };
                after(vec![egui::Event::PointerMoved(pos)]);
                after(vec![button(true)]);
                copied.extend(after(vec![button(false)]));
            }
        }
        let copied = Vec::from_iter(copied);
        assert_eq!(copied.len(), 2, "{copied:?}");
        assert!(copied[0].starts_with("48.84") && copied[0].contains(", 2.33"), "{copied:?}");
        assert_eq!(copied[1], "651000.000, 6861000.000, 40.000");
    }

    #[test]
    fn a_tape_fits_into_narrow_windows() {
        let place = Place::on(DVec3::Z, DVec3::new(651_000.0, 6_861_000.0, 40.0));
        let (tape, reference) =
            (marked(place, Record::default()), Reference::new("EPSG:2154", None));
        for [width, least] in [[1280.0, 400.0], [450.0, 300.0], [360.0, 300.0]] {
            let context = egui::Context::default();
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, 480.0));
            for _ in 0..3 {
                let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
                let mut output = context.run_ui(input, |ui| show(ui.ctx(), &tape, &reference));
                output.textures_delta.clear();
            }
            let layer = context.layer_id_at(egui::pos2(width - 20.0, 20.0)).expect("a tape");
            let area = context.memory(|memory| memory.area_rect(layer.id)).expect("a tape");
            assert!(screen.contains_rect(area) && area.width() > least, "{area} in {width}");
        }
    }

    #[test]
    fn a_wall_is_said_with_its_building() {
        let surface = PickedSurface::Mesh(SurfaceClass::Wall);
        let place = Place { surface, uncertainty_m: 0.5, ..Place::on(DVec3::Y, DVec3::ONE) };
        let record = Record { footprint: Some("b-12".to_owned()), ..Record::default() };
        let said = lines(&marked(place, record), &Reference::new("local", None));
        assert_eq!(figures(&said, "Measured on"), ["wall of building b-12"]);
        assert_eq!(figures(&said, "Position"), ["1.00, 1.00, 1.00 ± 50 cm"]);
        assert_eq!(figures(&said, "Photograph"), ["none sees it"]);
    }
}

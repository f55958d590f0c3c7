//! Marks of the measured places on the street, and a line between two of them.

use egui::{Align2, Color32, FontId, Pos2, Stroke};
use flaneur_scene::View;

use crate::commands::view::measurement::metres;
use crate::commands::view::measuring::Measuring;

const DARK: Color32 = Color32::from_black_alpha(180);
const RING: f32 = 6.0;

/// Draws them where `view` shows them.
pub(super) fn draw(context: &egui::Context, measuring: &Measuring, view: &View) {
    let scale = f64::from(context.pixels_per_point());
    let painter = context.layer_painter(egui::LayerId::background());
    let shown = |index: usize| {
        let marked = measuring.places().get(index)?;
        let (pixel, _) = view.camera.project(marked.place.position)?;
        let at = (pixel / scale).as_vec2();
        Some(Pos2::new(at.x, at.y))
    };
    let ends = [shown(0), shown(1)];
    if let [Some(a), Some(b)] = ends {
        painter.line_segment([a, b], Stroke::new(4.0, DARK));
        painter.line_segment([a, b], Stroke::new(2.0, Color32::WHITE));
        if let Some(measured) = measuring.measurement() {
            let above = a.lerp(b, 0.5) - egui::vec2(0.0, 14.0);
            write(
                &painter,
                above,
                Align2::CENTER_CENTER,
                &metres(measured.distance, measured.uncertainty),
            );
        }
    }
    for (at, letter) in ends.into_iter().zip(["A", "B"]) {
        let Some(at) = at else { continue };
        painter.circle_stroke(at, RING, Stroke::new(4.0, DARK));
        painter.circle_stroke(at, RING, Stroke::new(2.0, Color32::WHITE));
        write(&painter, at + egui::vec2(14.0, 0.0), Align2::LEFT_CENTER, letter);
    }
}

/// Where Enter acts: in the middle.
pub(super) fn draw_reticle(context: &egui::Context) {
    let painter = context.layer_painter(egui::LayerId::background());
    let middle = context.content_rect().center();
    painter.circle_stroke(middle, 9.0, Stroke::new(4.0, DARK));
    painter.circle_stroke(middle, 9.0, Stroke::new(2.0, Color32::WHITE));
    painter.circle_filled(middle, 2.5, DARK);
    painter.circle_filled(middle, 1.5, Color32::WHITE);
}

/// Light letters on a dark ground.
fn write(painter: &egui::Painter, at: Pos2, side: Align2, text: &str) {
    let font = FontId::proportional(14.0);
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::WHITE);
    let place = side.anchor_size(at, galley.size());
    painter.rect_filled(place.expand(3.0), 3.0, DARK);
    painter.galley(place.min, galley, Color32::WHITE);
}

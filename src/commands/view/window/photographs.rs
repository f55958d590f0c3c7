//! The photographs that see the place that was measured last, to be chosen from.

use egui::{Align2, RichText, TextWrapMode};

use super::panels::{self, inward};
use crate::commands::view::measurement::{date, rough_metres};
use crate::commands::view::measuring::Measuring;

/// The list takes at most so much of the window's height.
const SHARE: f32 = 0.3;
/// Height of its letters, points.
const LETTERS: f32 = 13.0;

/// Lists them in a corner, where there are any.
pub(super) fn show(context: &egui::Context, measuring: &mut Measuring) {
    let sights = measuring.sights();
    if sights.is_empty() {
        return;
    }
    let letter = if measuring.places().len() == 2 { "B" } else { "A" };
    let title = match sights.len() {
        1 => format!("1 photograph sees {letter}"),
        several => format!("{several} photographs see {letter}"),
    };
    let highest = SHARE * context.content_rect().height();
    let side = Align2::LEFT_BOTTOM;
    let area = egui::Area::new(egui::Id::unique("photographs")).anchor(side, inward(side));
    let list = |ui: &mut egui::Ui| {
        let mut chosen = None;
        for (index, sight) in sights.iter().enumerate() {
            let (taken, away) = (date(sight.time.as_deref()), rough_metres(sight.distance_m));
            let line = format!("{}/{}   {taken} · {away}", sight.panorama, sight.camera);
            let text = RichText::new(line).size(LETTERS);
            let button = egui::Button::new(text).wrap_mode(TextWrapMode::Extend);
            if ui.add(button).clicked() {
                chosen = Some(index);
            }
        }
        chosen
    };
    let shown = area.show(context, |ui| {
        let frame = egui::Frame::popup(ui.style());
        let framed = frame.show(ui, |ui| {
            ui.label(RichText::new(title).size(LETTERS));
            panels::list(highest).show(ui, list).inner
        });
        framed.inner
    });
    if let Some(index) = shown.inner {
        measuring.choose(index);
    }
}

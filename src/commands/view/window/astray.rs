//! Says that nothing of the scene is in sight, and leads back: as the web page does.

use egui::Align2;

const NOTHING: &str = "Nothing of this street is in sight from here.";
const BACK: &str = "Back to the street";

/// Width of what is said, points.
const WIDTH: f32 = 310.0;

/// Says so in the middle; whether someone wants to be led back.
pub(super) fn show(context: &egui::Context) -> bool {
    let area = egui::Area::new(egui::Id::unique("astray")).anchor(Align2::CENTER_CENTER, [0.0; 2]);
    let shown = area.show(context, |ui| {
        let framed = egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width(WIDTH);
            let centred = ui.vertical_centered(|ui| {
                ui.label(NOTHING);
                ui.button(BACK).clicked()
            });
            centred.inner
        });
        framed.inner
    });
    shown.inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_button_in_the_middle_leads_back_in_the_page_s_words() {
        let page = include_str!("../../../../services/web/src/strings.ts");
        for words in [NOTHING, BACK] {
            assert!(page.contains(&format!("{words:?}")), "the page does not say: {words}");
        }
        let context = egui::Context::default();
        let leads_back = |events: Vec<egui::Event>| {
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(640.0, 360.0));
            let input =
                egui::RawInput { screen_rect: Some(screen), events, ..egui::RawInput::default() };
            let mut leads_back = false;
            context.run_ui(input, |ui| leads_back = show(ui.ctx())).textures_delta.clear();
            leads_back
        };
        let clicked = |y: f32| {
            let pos = egui::pos2(320.0, y);
            let button = |pressed| egui::Event::PointerButton {
                pos,
                button: egui::PointerButton::Primary,
                pressed,
                modifiers: egui::Modifiers::NONE,
            };
            leads_back(vec![egui::Event::PointerMoved(pos)]);
            leads_back(vec![button(true)]);
            leads_back(vec![button(false)])
        };
        // Below the words.
        assert!((180..220).step_by(4).any(|y| clicked(y as f32)));
        assert!(!clicked(100.0) && !clicked(168.0) && !clicked(260.0));
    }
}

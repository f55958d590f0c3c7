//! The photograph that was chosen, in a window of its own over the street.

use egui::{Align2, Color32, ColorImage, RichText, Stroke, TextureHandle, TextureOptions};
use flaneur_services::place::StoredSight;
use glam::{DVec3, UVec2};

use super::screen::Screen;
use crate::commands::view::measurement::{date, rough_metres};
use crate::commands::view::measuring::Chosen;
use crate::commands::view::photograph::Photograph;
use crate::exit::Exit;

/// It takes at most so much of the window's sides.
const SHARE: [f64; 2] = [0.8, 0.65];
/// Its width where the photograph is narrower, points; less where the window has no room for it.
const WIDTH: f32 = 410.0;
/// Radius of the mark at the place, points.
const RING: f32 = 11.0;

/// A photograph that is shown, or will be.
pub(super) struct PhotographWindow {
    /// Of the question for it; answers to former ones come too late.
    pub(super) number: u64,
    chosen: Chosen,
    content: Content,
}

enum Content {
    Asked,
    Shown(TextureHandle, [f32; 2]),
    Failed(String),
}

/// What someone does with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wanted {
    Close,
    /// To stand where it was taken, and to look at the place.
    Stand([DVec3; 2]),
}

impl PhotographWindow {
    /// Before it is there.
    pub(super) fn new(number: u64, chosen: Chosen) -> Self {
        Self { number, chosen, content: Content::Asked }
    }

    /// Most pixels of a photograph in a window on `screen`.
    pub(super) fn room(screen: &Screen) -> UVec2 {
        (screen.size().as_dvec2() * glam::DVec2::from(SHARE)).as_uvec2().max(UVec2::ONE)
    }

    /// Takes the photograph, or why there is none.
    pub(super) fn take(&mut self, context: &egui::Context, developed: Result<Photograph, Exit>) {
        self.content = match developed {
            Ok(Photograph { image, mark }) => {
                let size = [image.width() as usize, image.height() as usize];
                let image = ColorImage::from_rgb(size, image.as_raw());
                let texture = context.load_texture("photograph", image, TextureOptions::LINEAR);
                Content::Shown(texture, mark.as_vec2().to_array())
            }
            Err(exit) => Content::Failed(exit.message()),
        };
    }

    /// Shows it; what someone wants of it.
    pub(super) fn show(&self, context: &egui::Context) -> Option<Wanted> {
        let Chosen { sight, place } = &self.chosen;
        let StoredSight { panorama, camera, time, centre, distance_m, .. } = sight;
        let (mut open, mut wanted) = (true, None);
        let window = egui::Window::new(format!("Photograph {panorama}/{camera}"))
            .open(&mut open)
            .collapsible(false)
            .resizable(false)
            .default_width(WIDTH)
            .pivot(Align2::CENTER_CENTER)
            .default_pos(context.content_rect().center());
        window.show(context, |ui| {
            // What is below it may be wider.
            ui.vertical_centered(|ui| match &self.content {
                Content::Asked => _ = ui.label("Loading ..."),
                Content::Failed(reason) => _ = ui.label(reason),
                Content::Shown(texture, mark) => show_marked(ui, texture, *mark),
            });
            ui.horizontal_wrapped(|ui| {
                if ui.button("Go to where it was taken").clicked() {
                    wanted = Some(Wanted::Stand([*centre, *place]));
                }
                let (taken, away) = (date(time.as_deref()), rough_metres(*distance_m));
                ui.label(RichText::new(format!("{taken} · {away} away")).small());
            });
        });
        wanted.or((!open).then_some(Wanted::Close))
    }
}

/// A picture, pixel by pixel, with a ring around a place of it.
fn show_marked(ui: &mut egui::Ui, texture: &TextureHandle, mark: [f32; 2]) {
    let size = texture.size_vec2() / ui.ctx().pixels_per_point();
    let (area, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let whole = egui::Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));
    let painter = ui.painter().with_clip_rect(area);
    painter.image(texture.id(), area, whole, Color32::WHITE);
    let at = area.min + egui::Vec2::from(mark) * area.size();
    painter.circle_stroke(at, RING, Stroke::new(4.0, Color32::from_black_alpha(160)));
    painter.circle_stroke(at, RING, Stroke::new(2.0, Color32::from_rgb(255, 216, 74)));
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use image::RgbImage;

    use super::*;

    #[test]
    fn a_photograph_is_in_the_middle_of_its_window() {
        for ([width, height], room) in
            [([120, 200], 900.0), ([312, 312], 900.0), ([700, 200], 900.0), ([288, 288], 360.0)]
        {
            let context = egui::Context::default();
            let sight = StoredSight {
                panorama: "7".to_owned(),
                camera: "left".to_owned(),
                time: Some("2024-05-14T09:06:41Z".to_owned()),
                centre: DVec3::ZERO,
                pixel: DVec2::ZERO,
                distance_m: 12.0,
                share: 1.0,
            };
            let mut window = PhotographWindow::new(0, Chosen { sight, place: DVec3::Y });
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(room, 480.0));
            let draw = |window: &PhotographWindow| {
                let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
                let mut output = context.run_ui(input, |ui| _ = window.show(ui.ctx()));
                output.textures_delta.clear();
                output.shapes
            };
            draw(&window);
            let image = RgbImage::new(width, height);
            window.take(&context, Ok(Photograph { image, mark: DVec2::splat(0.5) }));
            (0..3).for_each(|_| _ = draw(&window));
            // The mark is in the photograph's middle.
            let middle = draw(&window).into_iter().find_map(|clipped| match clipped.shape {
                egui::Shape::Circle(circle) => Some(circle.center),
                _ => None,
            });
            let middle = middle.expect("a mark");
            let layer = context.layer_id_at(middle).expect("a window");
            let area = context.memory(|memory| memory.area_rect(layer.id)).expect("a window");
            assert!((middle.x - area.center().x).abs() < 1.0, "{width}: {middle} in {area}");
            assert!(area.width() >= width as f32 && screen.contains_rect(area), "{width}: {area}");
        }
    }
}

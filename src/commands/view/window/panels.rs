//! What lies over the picture: figures, help, the tape, messages.

use std::time::{Duration, Instant};

use egui::{Align2, Color32, RichText, TextStyle, TextWrapMode};
use glam::{DVec2, DVec3};
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::figures::{Facts, figures};
use super::help::{HELP, HINT};
use super::photograph::{PhotographWindow, Wanted};
use super::{astray, photographs, ruler, screen, tape};
use crate::commands::view::measuring::Measuring;
use crate::commands::view::photograph::Photograph;
use crate::exit::Exit;

/// Margin of what stands at the window's borders, points.
pub(super) const MARGIN: f32 = 10.0;
/// Height of a line of text with its frame, points.
const LINE: f32 = 36.0;
/// What can be done takes at most so much of the window's height, below its title.
const HELP_SHARE: f32 = 0.78;
/// In narrower windows keys and what they do do not fit beside each other, points.
const HELP_WIDTH: f32 = 500.0;
/// Height of letters that are looked up rather than read, points.
const SMALL: f32 = 12.0;
/// In narrower windows figures and tape do not fit beside each other, points.
const WIDE: f32 = 760.0;
/// How long a message stands, and what is said in passing.
const MESSAGE: Duration = Duration::from_secs(8);
const MENTION: Duration = Duration::from_secs(3);
/// Whether what is loading still comes is looked after so often.
const LOOK_AFTER: Duration = Duration::from_secs(1);

/// The panels, and the library that draws them.
pub(super) struct PanelState {
    context: egui::Context,
    input: egui_winit::State,
    pub(super) shows_figures: bool,
    pub(super) shows_help: bool,
    /// Until someone does something.
    pub(super) shows_hint: bool,
    /// Where Enter acts.
    pub(super) shows_reticle: bool,
    pub(super) measuring: Measuring,
    pub(super) photograph: Option<PhotographWindow>,
    /// Where to go from a photograph, and what to look at.
    pub(super) destination: Option<[DVec3; 2]>,
    /// Nothing of the scene is in sight.
    pub(super) is_astray: bool,
    /// Someone wants to be led back to where there is.
    pub(super) leads_back: bool,
    /// What went wrong, or is shown, and until when that stands.
    message: Option<(String, Instant)>,
}

impl PanelState {
    /// None but the hint.
    pub(super) fn new(window: &Window, max_side: u32) -> Self {
        let context = egui::Context::default();
        context.set_theme(egui::Theme::Dark);
        context.all_styles_mut(make_legible);
        let side = usize::try_from(max_side).ok();
        let (root, scale, theme) =
            (egui::ViewportId::ROOT, window.scale_factor() as f32, window.theme());
        let input = egui_winit::State::new(context.clone(), root, window, Some(scale), theme, side);
        Self {
            context,
            input,
            shows_figures: false,
            shows_help: false,
            shows_hint: true,
            shows_reticle: false,
            measuring: Measuring::default(),
            photograph: None,
            destination: None,
            is_astray: false,
            leads_back: false,
            message: None,
        }
    }

    /// Takes the photograph that was asked for under a number.
    pub(super) fn take_photograph(&mut self, number: u64, developed: Result<Photograph, Exit>) {
        if let Some(window) = self.photograph.as_mut().filter(|window| window.number == number) {
            window.take(&self.context, developed);
        }
    }

    /// Says something for a while.
    pub(super) fn say(&mut self, what: String) {
        self.message = Some((what, Instant::now() + MESSAGE));
    }

    /// Says in passing what is shown from now on, or was done.
    pub(super) fn mention(&mut self, what: String) {
        self.message = Some((what, Instant::now() + MENTION));
    }

    /// Says nothing any more.
    pub(super) fn clear_message(&mut self) {
        self.message = None;
    }

    /// Takes note of an event.
    pub(super) fn notice(&mut self, window: &Window, event: &WindowEvent) {
        _ = self.input.on_window_event(window, event);
    }

    /// Whether what is done at a pixel of the window is done to a panel: by where panels are, not by what
    /// the pointer was over when they were drawn last, because a hand may be faster than that.
    pub(super) fn is_at(&self, pixel: DVec2) -> bool {
        let at = (pixel / f64::from(self.context.pixels_per_point())).as_vec2();
        // Behind all panels lies a layer that covers the window.
        let layer = self.context.layer_id_at(egui::pos2(at.x, at.y));
        layer.is_some_and(|layer| layer.order != egui::Order::Background)
    }

    /// Whether one of their buttons has the keyboard: who walks through them with Tab.
    pub(super) fn have_keyboard(&self) -> bool {
        self.context.memory(|memory| memory.focused().is_some())
    }

    /// Lays the panels out. After how long they are to be drawn again though nothing happens, if ever.
    pub(super) fn lay_out(
        &mut self,
        window: &Window,
        event_loop: &ActiveEventLoop,
        facts: &Facts<'_>,
    ) -> (screen::Panels, Option<Duration>) {
        let input = self.input.take_egui_input(window);
        let context = self.context.clone();
        let output = context.run_ui(input, |ui| self.show(ui.ctx(), facts));
        let delays = output.viewport_output.values().map(|viewport| viewport.repaint_delay);
        let again = delays.min().filter(|delay| *delay < MESSAGE);
        self.input.handle_platform_output_with_event_loop(
            window,
            event_loop,
            output.platform_output,
        );
        let pixels_per_point = output.pixels_per_point;
        let primitives = context.tessellate(output.shapes, pixels_per_point);
        let textures = output.textures_delta;
        (screen::Panels { primitives, textures, pixels_per_point }, again)
    }

    fn show(&mut self, context: &egui::Context, facts: &Facts<'_>) {
        ruler::draw(context, &self.measuring, facts.view);
        if self.shows_reticle {
            ruler::draw_reticle(context);
        }
        if self.measuring.is_on() {
            context.set_cursor_icon(egui::CursorIcon::Crosshair);
            tape::show(context, &self.measuring, facts.reference);
            photographs::show(context, &mut self.measuring);
        }
        if let Some(wanted) = self.photograph.as_ref().and_then(|window| window.show(context)) {
            self.photograph = None;
            self.destination = match wanted {
                Wanted::Close => None,
                Wanted::Stand(destination) => Some(destination),
            };
        }
        self.leads_back = self.is_astray && astray::show(context);
        if self.shows_hint && !self.measuring.is_on() {
            label(context, "hint", Align2::LEFT_BOTTOM, HINT);
        }
        if let Some(loading) = facts.loading() {
            label(context, "loading", Align2::RIGHT_BOTTOM, &loading);
            // A server that has gone tells nobody.
            context.request_repaint_after(LOOK_AFTER);
        }
        if let Some(copied) = copied(context) {
            self.mention(format!("copied: {copied}"));
        }
        let now = Instant::now();
        self.message.take_if(|(_, until)| *until <= now);
        if let Some((message, until)) = &self.message {
            label(context, "message", Align2::CENTER_BOTTOM, message);
            let left = until.saturating_duration_since(now);
            context.request_repaint_after(left.min(MESSAGE / 2));
        }
        // Where two do not fit beside each other, the one that was asked for last is shown.
        let narrow = context.content_rect().width() < WIDE;
        let hidden = self.shows_help || narrow && self.measuring.is_on();
        if self.shows_figures && !hidden {
            show_figures(context, &figures(facts));
        }
        if self.shows_help {
            show_help(context, &mut self.shows_help);
        }
    }
}

/// Letters that are read before a street: light ones, and large enough.
fn make_legible(style: &mut egui::Style) {
    style.visuals.override_text_color = Some(Color32::from_gray(235));
    for (kind, font) in &mut style.text_styles {
        font.size = match kind {
            TextStyle::Heading => 16.0,
            _ => 14.0,
        };
    }
}

/// Text on the picture, in as few lines as fit. Whoever clicks there clicks the picture.
fn label(context: &egui::Context, id: &str, side: Align2, text: &str) {
    let area = egui::Area::new(egui::Id::unique(id)).interactable(false);
    let mut inward = egui::Vec2::from(inward(side));
    if side == Align2::CENTER_BOTTOM {
        // Above those in the corners.
        inward.y -= LINE;
    }
    let widest = context.content_rect().width() - 4.0 * MARGIN;
    area.anchor(side, inward).show(context, |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width(widest);
            ui.add(egui::Label::new(text).wrap_mode(TextWrapMode::Wrap));
        });
    });
}

/// Lines of two columns in a corner, small, below all other panels, and through which one clicks.
fn show_figures(context: &egui::Context, lines: &[(&str, String)]) {
    let side = Align2::LEFT_TOP;
    let area = egui::Area::new(egui::Id::unique("figures")).interactable(false);
    area.order(egui::Order::Background).anchor(side, inward(side)).show(context, |ui| {
        let frame = egui::Frame::popup(ui.style()).fill(Color32::from_black_alpha(170));
        frame.show(ui, |ui| {
            egui::Grid::new("figures").spacing([10.0, 1.0]).min_row_height(0.0).show(ui, |ui| {
                for (what, how) in lines {
                    ui.label(RichText::new(*what).size(SMALL));
                    ui.label(RichText::new(how).size(SMALL).monospace());
                    ui.end_row();
                }
            });
        });
    });
}

/// What can be done, until it is closed.
fn show_help(context: &egui::Context, open: &mut bool) {
    let window = egui::Window::new("How to move").open(open).collapsible(false).resizable(false);
    let highest = HELP_SHARE * context.content_rect().height();
    window.anchor(Align2::CENTER_CENTER, [0.0; 2]).show(context, |ui| {
        list(highest).show(ui, |ui| {
            if context.content_rect().width() < HELP_WIDTH {
                for (what, how) in HELP {
                    ui.strong(what);
                    ui.horizontal(|ui| {
                        ui.add_space(MARGIN);
                        ui.label(how);
                    });
                }
                return;
            }
            egui::Grid::new("help").show(ui, |ui| {
                for (what, how) in HELP {
                    ui.strong(what);
                    ui.label(how);
                    ui.end_row();
                }
            });
        });
    });
}

/// What a panel has copied since they began to be laid out.
pub(super) fn copied(context: &egui::Context) -> Option<String> {
    let text = |command: &egui::OutputCommand| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    };
    context.output(|output| output.commands.iter().find_map(text))
}

/// What grows with its lines up to `highest` points, and is scrolled from there on.
pub(super) fn list(highest: f32) -> egui::ScrollArea {
    // Otherwise it would keep to the height that it had with fewer.
    egui::ScrollArea::vertical().max_height(highest).min_scrolled_height(highest)
}

/// From a side of the window towards its middle.
pub(super) fn inward(side: Align2) -> [f32; 2] {
    side.0.map(|align| MARGIN * -align.to_sign())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_lie_below_whatever_is_said_in_the_same_place() {
        let context = egui::Context::default();
        let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(300.0, 60.0));
        let mut texts = Vec::new();
        for _ in 0..3 {
            let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
            let mut output = context.run_ui(input, |ui| {
                astray::show(ui.ctx());
                show_figures(ui.ctx(), &[("frame", "16.7 ms".to_owned())]);
            });
            output.textures_delta.clear();
            let text = |clipped: egui::epaint::ClippedShape| match clipped.shape {
                egui::Shape::Text(text) => Some(text.galley.text().to_owned()),
                _ => None,
            };
            texts = output.shapes.into_iter().filter_map(text).collect();
        }
        // What is drawn last is on top.
        assert_eq!(texts[..2], ["frame", "16.7 ms"]);
        assert!(texts.len() > 2, "{texts:?}");
    }

    #[test]
    fn help_fits_into_a_window_or_is_scrolled() {
        for [width, height] in [[1280.0, 720.0], [640.0, 480.0], [640.0, 360.0], [360.0, 640.0]] {
            let context = egui::Context::default();
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height));
            for _ in 0..4 {
                let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
                let mut open = true;
                context.run_ui(input, |ui| show_help(ui.ctx(), &mut open)).textures_delta.clear();
            }
            let layer = context.layer_id_at(screen.center()).expect("a window");
            let area = context.memory(|memory| memory.area_rect(layer.id)).expect("a window");
            assert!(screen.contains_rect(area), "{area} in {screen}");
            assert!(area.height() > 300.0, "{area}");
        }
    }
}

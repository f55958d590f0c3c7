//! What lies over the picture: figures, help, the place that was clicked, messages.

use std::time::{Duration, Instant};

use egui::{Align2, Color32, Stroke};
use flaneur_scene::View;
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::figures::{Facts, figures};
use super::screen;
use crate::commands::view::place::Place;

/// What can be done, and how.
const HELP: [(&str, &str); 11] = [
    ("drag", "look around"),
    ("wheel", "zoom"),
    ("W A S D", "walk; with Shift, run"),
    ("arrows", "walk and turn"),
    ("click the ground", "go there"),
    ("click a wall", "face it"),
    ("double click", "go to the nearest photograph"),
    (
        "1 to 9",
        "hybrid, mesh, points, points-colour, wireframe, depth, normals, sources, uncertainty",
    ),
    ("drop a scene", "open it"),
    ("O or F1", "figures"),
    ("H", "this help"),
];
const HINT: &str = "H: help   O: figures";

/// Margin of what stands at the window's borders, points.
const MARGIN: f32 = 10.0;
/// How long a message stands.
const MESSAGE: Duration = Duration::from_secs(8);

/// The panels, and the library that draws them.
pub(super) struct PanelState {
    context: egui::Context,
    input: egui_winit::State,
    pub(super) shows_figures: bool,
    pub(super) shows_help: bool,
    /// Until someone does something.
    pub(super) shows_hint: bool,
    /// What was clicked.
    pub(super) place: Option<Place>,
    /// What went wrong, and when.
    message: Option<(String, Instant)>,
}

impl PanelState {
    /// None but the hint.
    pub(super) fn new(window: &Window, max_side: u32) -> Self {
        let context = egui::Context::default();
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
            place: None,
            message: None,
        }
    }

    /// Says something for a while.
    pub(super) fn say(&mut self, what: String) {
        self.message = Some((what, Instant::now()));
    }

    /// Says nothing any more, and marks no place.
    pub(super) fn clear(&mut self) {
        (self.place, self.message) = (None, None);
    }

    /// Takes note of an event; whether it belongs to a panel.
    pub(super) fn notice(&mut self, window: &Window, event: &WindowEvent) -> bool {
        self.input.on_window_event(window, event).consumed
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
        if let Some(place) = &self.place {
            mark(context, place, facts.view);
            let text = format!("{place}   {}", facts.crs);
            label(context, "place", Align2::CENTER_BOTTOM, &text);
        }
        if self.shows_hint {
            label(context, "hint", Align2::LEFT_BOTTOM, HINT);
        }
        if let Some(loading) = facts.loading() {
            label(context, "loading", Align2::RIGHT_BOTTOM, &loading);
        }
        if let Some((message, since)) = &self.message {
            label(context, "message", Align2::CENTER_TOP, message);
            match MESSAGE.checked_sub(since.elapsed()) {
                Some(left) => context.request_repaint_after(left.min(MESSAGE / 2)),
                None => self.message = None,
            }
        }
        if self.shows_figures {
            table(context, "figures", Align2::LEFT_TOP, &mut self.shows_figures, &figures(facts));
        }
        if self.shows_help {
            let lines = HELP.map(|(what, how)| (what, how.to_owned()));
            table(context, "help", Align2::RIGHT_TOP, &mut self.shows_help, &lines);
        }
    }
}

/// A line of text on the picture.
fn label(context: &egui::Context, id: &str, side: Align2, text: &str) {
    let area = egui::Area::new(egui::Id::unique(id)).interactable(false);
    area.anchor(side, inward(side)).show(context, |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| ui.add(egui::Label::new(text).extend()));
    });
}

/// Lines of two columns, which can be closed.
fn table(
    context: &egui::Context,
    id: &str,
    side: Align2,
    open: &mut bool,
    lines: &[(&str, String)],
) {
    let window = egui::Window::new(id).open(open).collapsible(false).resizable(false);
    window.anchor(side, inward(side)).show(context, |ui| {
        egui::Grid::new(id).show(ui, |ui| {
            for (what, how) in lines {
                ui.strong(*what);
                ui.monospace(how);
                ui.end_row();
            }
        });
    });
}

/// From a side of the window towards its middle.
fn inward(side: Align2) -> [f32; 2] {
    side.0.map(|align| MARGIN * -align.to_sign())
}

/// A ring about a place, where the view shows it.
fn mark(context: &egui::Context, place: &Place, view: &View) {
    let Some((pixel, _)) = view.camera.project(place.position) else { return };
    let at = (pixel / f64::from(context.pixels_per_point())).as_vec2();
    let painter = context.layer_painter(egui::LayerId::background());
    let at = egui::pos2(at.x, at.y);
    painter.circle_stroke(at, 7.0, Stroke::new(3.0, Color32::from_black_alpha(160)));
    painter.circle_stroke(at, 7.0, Stroke::new(1.5, Color32::WHITE));
}

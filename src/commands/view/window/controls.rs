//! What keys and mouse do.

use std::time::Instant;

use glam::DVec2;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::PhysicalKey;

use super::keys::{Stroke, ZOOM, is_for_buttons, step, stroke};
use super::{App, layers};

/// So many pixels of a touchpad are a notch of a wheel.
const PIXELS_A_NOTCH: f64 = 40.0;
/// No turn of a wheel counts for more notches.
const MOST_NOTCHES: f64 = 3.0;

impl App {
    /// Does what an event asks for; a panel's pointer is not the picture's.
    pub(super) fn control(&mut self, event: &WindowEvent) {
        let now = Instant::now();
        let Some(open) = &mut self.open else { return };
        open.wake();
        let of_panel = open.panels.is_at(open.pointer.at());
        match event {
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(event, now),
            WindowEvent::ModifiersChanged(modifiers) => {
                open.modifiers = modifiers.state();
                self.visitor.hurry(modifiers.state().shift_key());
            }
            WindowEvent::Focused(false) => {
                open.pointer.lose();
                self.visitor.release_all();
            }
            WindowEvent::CursorMoved { position, .. } => {
                let moved = open.pointer.moves(DVec2::new(position.x, position.y));
                if let Some((from, to)) = moved {
                    self.visitor.drag(from, to, open.screen.size());
                }
            }
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                open.panels.shows_hint = false;
                open.panels.shows_reticle = false;
                match state {
                    ElementState::Pressed if !of_panel => open.pointer.press(),
                    ElementState::Pressed => {}
                    ElementState::Released => {
                        if let Some(clicked) = open.pointer.release(now) {
                            self.click(clicked.at, clicked.double);
                        }
                    }
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !of_panel => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / PIXELS_A_NOTCH,
                };
                let factor = ZOOM.powf(notches.clamp(-MOST_NOTCHES, MOST_NOTCHES));
                self.visitor.zoom(factor, open.pointer.at(), open.screen.size());
            }
            WindowEvent::DroppedFile(path) => self.open_dropped(path),
            _ => {}
        }
    }

    fn key(&mut self, event: &KeyEvent, now: Instant) {
        let PhysicalKey::Code(code) = event.physical_key else { return };
        let Some(open) = &mut self.open else { return };
        let pressed = event.state == ElementState::Pressed;
        let key = event.logical_key.as_ref();
        if pressed && open.panels.have_keyboard() && is_for_buttons(&key) {
            return;
        }
        // Those with Ctrl and the like belong to the desktop.
        let modifiers = open.modifiers;
        let of_others = modifiers.control_key() || modifiers.alt_key() || modifiers.super_key();
        if let Some(step) = step(code) {
            if !pressed {
                self.visitor.release(step);
            } else if !of_others {
                self.visitor.press(step, now);
            }
        }
        if !pressed || of_others {
            return;
        }
        open.panels.shows_hint = false;
        let stroke = stroke(&key, code);
        if let Some(stroke) = stroke.filter(|stroke| !event.repeat || stroke.repeats()) {
            self.stroke(stroke, now);
        }
    }

    fn stroke(&mut self, stroke: Stroke, now: Instant) {
        let Some(open) = &mut self.open else { return };
        let (panels, size) = (&mut open.panels, open.screen.size());
        let middle = size.as_dvec2() / 2.0;
        // Where Enter acts is shown to those who use it.
        panels.shows_reticle |= matches!(stroke, Stroke::Act | Stroke::Measure);
        match stroke {
            Stroke::Act if panels.is_astray => self.lead_back(),
            Stroke::Act => self.click(middle, false),
            Stroke::NearestPhotograph => self.find_photograph(self.visitor.pose().eye),
            Stroke::Level => self.visitor.level(now),
            Stroke::Zoom(factor) => self.visitor.zoom(factor, middle, size),
            Stroke::Measure => panels.measuring.toggle(),
            Stroke::Leave if panels.photograph.is_some() => panels.photograph = None,
            Stroke::Leave => {
                panels.measuring.close();
                panels.clear_message();
                panels.shows_help = false;
                panels.shows_reticle = false;
            }
            Stroke::Help => panels.shows_help ^= true,
            Stroke::Figures => panels.shows_figures ^= true,
            Stroke::Layer(mode) => {
                self.mode = mode;
                panels.mention(layers::words(mode).to_owned());
            }
        }
    }
}

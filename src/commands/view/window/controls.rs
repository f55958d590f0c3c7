//! What keys and mouse do.

use std::time::Instant;

use flaneur_renderer::Mode;
use glam::DVec2;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};

use super::App;
use crate::commands::view::visitor::Step;

/// So many pixels of a touchpad are a notch of a wheel.
const PIXELS_A_NOTCH: f64 = 40.0;

impl App {
    /// Does what an event asks for; a panel's pointer is not the picture's.
    pub(super) fn control(&mut self, event: &WindowEvent, of_panel: bool) {
        let now = Instant::now();
        let Some(open) = &mut self.open else { return };
        open.wake();
        match event {
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(event, now),
            WindowEvent::ModifiersChanged(modifiers) => {
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
                self.visitor.zoom(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / PIXELS_A_NOTCH,
                });
            }
            WindowEvent::DroppedFile(path) => self.open_dropped(path),
            _ => {}
        }
    }

    fn key(&mut self, event: &KeyEvent, now: Instant) {
        let PhysicalKey::Code(code) = event.physical_key else { return };
        let pressed = event.state == ElementState::Pressed;
        if let Some(step) = step(code) {
            if pressed {
                self.visitor.press(step, now);
            } else {
                self.visitor.release(step);
            }
        }
        let Some(open) = &mut self.open else { return };
        if !pressed || event.repeat {
            return;
        }
        let panels = &mut open.panels;
        panels.shows_hint = false;
        match code {
            KeyCode::KeyO | KeyCode::F1 => panels.shows_figures ^= true,
            KeyCode::KeyH => panels.shows_help ^= true,
            KeyCode::Escape => {
                panels.clear();
                panels.shows_help = false;
            }
            code => self.mode = mode(code).unwrap_or(self.mode),
        }
    }
}

fn step(code: KeyCode) -> Option<Step> {
    Some(match code {
        KeyCode::KeyW | KeyCode::ArrowUp => Step::Ahead,
        KeyCode::KeyS | KeyCode::ArrowDown => Step::Back,
        KeyCode::KeyA => Step::Left,
        KeyCode::KeyD => Step::Right,
        KeyCode::ArrowLeft => Step::TurnLeft,
        KeyCode::ArrowRight => Step::TurnRight,
        _ => return None,
    })
}

fn mode(code: KeyCode) -> Option<Mode> {
    let digit = match code {
        KeyCode::Digit1 | KeyCode::Numpad1 => 0,
        KeyCode::Digit2 | KeyCode::Numpad2 => 1,
        KeyCode::Digit3 | KeyCode::Numpad3 => 2,
        KeyCode::Digit4 | KeyCode::Numpad4 => 3,
        KeyCode::Digit5 | KeyCode::Numpad5 => 4,
        KeyCode::Digit6 | KeyCode::Numpad6 => 5,
        KeyCode::Digit7 | KeyCode::Numpad7 => 6,
        KeyCode::Digit8 | KeyCode::Numpad8 => 7,
        KeyCode::Digit9 | KeyCode::Numpad9 => 8,
        _ => return None,
    };
    Mode::ALL.get(digit).copied()
}

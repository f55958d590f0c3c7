//! What keys mean: the same as on the web page, and O for the figures.

use flaneur_renderer::Mode;
use winit::keyboard::{Key, KeyCode, NamedKey};

use super::layers::LAYERS;
use crate::commands::view::visitor::Step;

/// What a notch of a wheel or a stroke of a key zooms by.
pub(super) const ZOOM: f64 = 1.15;

/// What a stroke of a key does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Stroke {
    /// What a click in the middle does.
    Act,
    NearestPhotograph,
    Level,
    /// Narrows (> 1) or widens (< 1) the view.
    Zoom(f64),
    Measure,
    Leave,
    Help,
    Figures,
    Layer(Mode),
}

impl Stroke {
    /// Whether it does so again and again while the key is down.
    pub(super) fn repeats(self) -> bool {
        matches!(self, Self::Zoom(_))
    }
}

/// What a stroke does: by what is written on the key, and for digits by its place.
pub(super) fn stroke(key: &Key<&str>, code: KeyCode) -> Option<Stroke> {
    Some(match *key {
        Key::Named(NamedKey::Enter | NamedKey::Space) => Stroke::Act,
        Key::Named(NamedKey::Home) => Stroke::Level,
        Key::Named(NamedKey::Escape) => Stroke::Leave,
        Key::Named(NamedKey::F1) => Stroke::Figures,
        Key::Character("g" | "G") => Stroke::NearestPhotograph,
        Key::Character("+" | "=") => Stroke::Zoom(ZOOM),
        Key::Character("-") => Stroke::Zoom(1.0 / ZOOM),
        Key::Character("m" | "M") => Stroke::Measure,
        Key::Character("?" | "h" | "H") => Stroke::Help,
        Key::Character("o" | "O") => Stroke::Figures,
        _ => Stroke::Layer(layer(code)?),
    })
}

/// Whether a button of a panel that has the keyboard takes a key: what presses it, leads to the others, and
/// leaves them.
pub(super) fn is_for_buttons(key: &Key<&str>) -> bool {
    use NamedKey::{ArrowDown, ArrowLeft, ArrowRight, ArrowUp, Enter, Escape, Space};
    let Key::Named(named) = key else { return false };
    matches!(named, Enter | Space | Escape | ArrowUp | ArrowDown | ArrowLeft | ArrowRight)
}

/// Which way a key walks while it is down.
pub(super) fn step(code: KeyCode) -> Option<Step> {
    Some(match code {
        KeyCode::KeyW | KeyCode::ArrowUp => Step::Ahead,
        KeyCode::KeyS | KeyCode::ArrowDown => Step::Back,
        KeyCode::KeyA => Step::Left,
        KeyCode::KeyD => Step::Right,
        KeyCode::ArrowLeft => Step::TurnLeft,
        KeyCode::ArrowRight => Step::TurnRight,
        KeyCode::PageUp => Step::TiltUp,
        KeyCode::PageDown => Step::TiltDown,
        _ => return None,
    })
}

fn layer(code: KeyCode) -> Option<Mode> {
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
    LAYERS.get(digit).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_mean_what_they_mean_on_the_page() {
        let typed = |text| stroke(&Key::Character(text), KeyCode::KeyX);
        let named = |name| stroke(&Key::Named(name), KeyCode::F24);
        let strokes = [
            (named(NamedKey::Enter), Stroke::Act),
            (named(NamedKey::Space), Stroke::Act),
            (named(NamedKey::Home), Stroke::Level),
            (named(NamedKey::Escape), Stroke::Leave),
            (typed("g"), Stroke::NearestPhotograph),
            (typed("M"), Stroke::Measure),
            (typed("?"), Stroke::Help),
            (typed("h"), Stroke::Help),
            (typed("o"), Stroke::Figures),
            (typed("+"), Stroke::Zoom(1.15)),
            (typed("="), Stroke::Zoom(1.15)),
        ];
        for (done, expected) in strokes {
            assert_eq!(done, Some(expected));
        }
        let out = typed("-").expect("a stroke");
        assert!(matches!(out, Stroke::Zoom(factor) if factor * ZOOM == 1.0) && out.repeats());
        assert!(!Stroke::Measure.repeats());
        assert_eq!((typed("x"), named(NamedKey::Tab)), (None, None));
    }

    #[test]
    fn digits_choose_layers_whatever_is_written_on_them() {
        // As on a French keyboard.
        let fourth = stroke(&Key::Character("'"), KeyCode::Digit4);
        assert_eq!(fourth, Some(Stroke::Layer(Mode::Sources)));
        let fifth = stroke(&Key::Character("5"), KeyCode::Numpad5);
        assert_eq!(fifth, Some(Stroke::Layer(Mode::Uncertainty)));
        // There the minus is on the six: what is written counts first.
        assert!(matches!(stroke(&Key::Character("-"), KeyCode::Digit6), Some(Stroke::Zoom(_))));
        assert_eq!(stroke(&Key::Character("0"), KeyCode::Digit0), None);
    }

    #[test]
    fn buttons_take_what_presses_and_leaves_them() {
        let named = |name| is_for_buttons(&Key::Named(name));
        assert!([NamedKey::Enter, NamedKey::Escape, NamedKey::ArrowUp].into_iter().all(named));
        assert!(!named(NamedKey::Home) && !is_for_buttons(&Key::Character("m")));
    }

    #[test]
    fn held_keys_walk_turn_and_tilt() {
        assert_eq!(step(KeyCode::KeyW), Some(Step::Ahead));
        assert_eq!(step(KeyCode::ArrowLeft), Some(Step::TurnLeft));
        let tilts = [KeyCode::PageUp, KeyCode::PageDown].map(step);
        assert_eq!(tilts, [Some(Step::TiltUp), Some(Step::TiltDown)]);
        assert_eq!(step(KeyCode::KeyM), None);
    }
}

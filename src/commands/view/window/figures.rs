//! Figures about what is shown, as lines of text.

use std::time::Duration;

use flaneur_renderer::Mode;
use flaneur_scene::View;

use super::tape::Reference;
use crate::commands::view::painter::Shown;
use crate::commands::view::pose::Pose;

/// What there is to tell.
pub(super) struct Facts<'a> {
    pub(super) pose: &'a Pose,
    pub(super) view: &'a View,
    pub(super) mode: Mode,
    /// The last frame; its pixels have gone to the device.
    pub(super) shown: Option<&'a Shown>,
    /// What the window itself took to draw the last time.
    pub(super) drawing: Duration,
    pub(super) scene: &'a str,
    pub(super) reference: &'a Reference,
    pub(super) adapter: &'a str,
    /// No server of the scene can be reached.
    pub(super) cut_off: bool,
}

impl Facts<'_> {
    /// What is said while the picture is not yet what it will be.
    pub(super) fn loading(&self) -> Option<String> {
        let to_come = match self.shown {
            None => None,
            Some(shown) if shown.remaining > 0 && !shown.is_final => Some(shown.remaining),
            Some(_) => return None,
        };
        Some(loading(self.scene, to_come, self.cut_off))
    }
}

/// What is said of so many parts that are still to come; `None` where not even that is known.
fn loading(scene: &str, to_come: Option<u64>, cut_off: bool) -> String {
    match to_come {
        _ if cut_off => "the server cannot be reached; trying again".to_owned(),
        None => format!("opening {scene}"),
        Some(remaining) => format!("loading: {} to come", parts(remaining)),
    }
}

/// A line for each figure: what it is of, and what it is.
pub(super) fn figures(facts: &Facts<'_>) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    let mut line = |what, how| lines.push((what, how));
    if let Some(shown) = facts.shown {
        line("frame", frame(shown));
        let stats = &shown.stats;
        let of = |drawn: u64, all: u64| format!("{} of {}", count(drawn), count(all));
        line("points", of(stats.points_drawn, stats.points));
        line("triangles", of(stats.triangles_drawn, stats.triangles));
        line("photographs", of(stats.images_drawn, stats.images));
        let streamed = &shown.streamed;
        line("received", bytes(streamed.bytes_received));
        let (hits, misses) = (streamed.cache_hits, streamed.cache_misses);
        line("cache", format!("{} hits, {} misses", count(hits), count(misses)));
        line("to come", count(shown.remaining));
    }
    line("window", milliseconds(facts.drawing));
    line("mode", facts.mode.name().to_owned());
    let pose = facts.pose;
    line("eye", format!("{:.2} {:.2} {:.2}", pose.eye.x, pose.eye.y, pose.eye.z));
    let degrees = [pose.heading, pose.pitch, pose.fov_y].map(f64::to_degrees);
    line("looks", format!("{:.1}°, {:+.1}°, {:.1}° high", degrees[0], degrees[1], degrees[2]));
    let size = facts.view.size();
    line("size", format!("{} x {}", size.x, size.y));
    line("scene", format!("{}, {}", facts.scene, facts.reference.code));
    line("adapter", facts.adapter.to_owned());
    lines
}

fn frame(shown: &Shown) -> String {
    let took = milliseconds(shown.took);
    match (shown.budget, shown.is_final) {
        (Some(budget), _) => {
            let held = if budget.held { "held" } else { "not held" };
            let (asked, rung) = (milliseconds(budget.asked), budget.rung + 1);
            format!("{took}, budget {asked} {held}, rung {rung} of {}", budget.rungs)
        }
        (None, true) => format!("{took}, final"),
        (None, false) => took,
    }
}

fn milliseconds(time: Duration) -> String {
    format!("{:.1} ms", time.as_secs_f64() * 1e3)
}

/// A number with thin spaces between thousands.
fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

fn parts(number: u64) -> String {
    format!("{} {}", count(number), if number == 1 { "part" } else { "parts" })
}

fn bytes(number: u64) -> String {
    format!("{:.1} MB", number as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_promised_of_a_server_out_of_reach() {
        assert_eq!(loading("paris", None, false), "opening paris");
        assert_eq!(loading("paris", Some(5041), false), "loading: 5 041 parts to come");
        for to_come in [None, Some(5041)] {
            let said = loading("paris", to_come, true);
            assert_eq!(said, "the server cannot be reached; trying again");
        }
    }

    #[test]
    fn numbers_are_written_to_be_read() {
        let counts = [0, 999, 1000, 1_234_567].map(count);
        assert_eq!(counts, ["0", "999", "1 000", "1 234 567"]);
        assert_eq!([1, 2].map(parts), ["1 part", "2 parts"]);
        assert_eq!(bytes(12_345_678), "12.3 MB");
        assert_eq!(milliseconds(Duration::from_micros(16_660)), "16.7 ms");
    }
}

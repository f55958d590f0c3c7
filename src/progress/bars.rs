//! A stage as a bar with rate and time left.

use std::fmt::Write;
use std::time::Duration;

use flaneur_services::ingest::{Stage, Unit};
use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};

use super::amount::{amount, duration};

/// A bar, or a spinner where the total is not known. It disappears when dropped.
pub(super) struct BarStage {
    bar: ProgressBar,
}

impl BarStage {
    pub(super) fn new(bars: &MultiProgress, name: &str, total: u64, unit: Unit) -> Self {
        let bar =
            bars.add(if total == 0 { ProgressBar::no_length() } else { ProgressBar::new(total) });
        bar.set_style(style(total, unit));
        bar.set_message(name.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar }
    }
}

impl Stage for BarStage {
    fn advance(&self, n: u64) {
        self.bar.inc(n);
    }
}

impl Drop for BarStage {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

fn style(total: u64, unit: Unit) -> ProgressStyle {
    let template = if total == 0 {
        "{spinner} {msg}: {done}, {rate}"
    } else {
        "{spinner} {msg:24} [{bar:30}] {done} of {total}, {rate}, {left} left"
    };
    ProgressStyle::with_template(template)
        .expect("the template above is well formed")
        .progress_chars("=> ")
        .with_key("done", move |state: &ProgressState, text: &mut dyn Write| {
            let _ = write!(text, "{}", amount(state.pos() as f64, unit));
        })
        .with_key("total", move |state: &ProgressState, text: &mut dyn Write| {
            let _ = write!(text, "{}", amount(state.len().unwrap_or(0) as f64, unit));
        })
        .with_key("rate", move |state: &ProgressState, text: &mut dyn Write| {
            let _ = write!(text, "{}/s", amount(state.per_sec(), unit));
        })
        .with_key("left", |state: &ProgressState, text: &mut dyn Write| {
            let _ = write!(text, "{}", duration(state.eta()));
        })
}

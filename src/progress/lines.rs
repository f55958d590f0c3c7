//! A stage as a plain line every few seconds, for logs and pipes.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use flaneur_services::ingest::{Stage, Unit};

use super::Console;
use super::amount::{amount, duration};

/// Time between two lines of one stage.
const INTERVAL: Duration = Duration::from_secs(5);

/// Speaks while it lasts, and once at its end.
pub(super) struct LineStage {
    console: Console,
    name: String,
    total: u64,
    unit: Unit,
    started: Instant,
    state: Mutex<State>,
}

struct State {
    done: u64,
    spoke: Instant,
}

impl LineStage {
    pub(super) fn new(console: Console, name: &str, total: u64, unit: Unit) -> Self {
        let started = Instant::now();
        let state = Mutex::new(State { done: 0, spoke: started });
        Self { console, name: name.to_owned(), total, unit, started, state }
    }
}

impl Stage for LineStage {
    fn advance(&self, n: u64) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.done = state.done.saturating_add(n);
        if state.spoke.elapsed() >= INTERVAL {
            state.spoke = Instant::now();
            let elapsed = self.started.elapsed();
            self.console.line(&running(&self.name, state.done, self.total, self.unit, elapsed));
        }
    }
}

impl Drop for LineStage {
    fn drop(&mut self) {
        let done = self.state.get_mut().unwrap_or_else(PoisonError::into_inner).done;
        let elapsed = self.started.elapsed();
        let rate = amount(rate(done, elapsed), self.unit);
        self.console.line(&format!(
            "{}: {} in {} ({rate}/s)",
            self.name,
            amount(done as f64, self.unit),
            duration(elapsed)
        ));
    }
}

fn running(name: &str, done: u64, total: u64, unit: Unit, elapsed: Duration) -> String {
    let (so_far, rate) = (amount(done as f64, unit), rate(done, elapsed));
    let rate_text = amount(rate, unit);
    if total == 0 {
        return format!("{name}: {so_far}, {rate_text}/s");
    }
    let left = total.saturating_sub(done) as f64 / rate;
    let left = Duration::try_from_secs_f64(left).map_or_else(|_| "unknown".to_owned(), duration);
    format!("{name}: {so_far} of {}, {rate_text}/s, {left} left", amount(total as f64, unit))
}

fn rate(done: u64, elapsed: Duration) -> f64 {
    done as f64 / elapsed.as_secs_f64().max(1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_tells_rate_and_time_left() {
        let line = running("sort", 2_000_000, 6_000_000, Unit::Points, Duration::from_secs(2));
        assert_eq!(line, "sort: 2.00 M points of 6.00 M points, 1.00 M points/s, 4 s left");
        let line = running("sort", 0, 10, Unit::Items, Duration::from_secs(2));
        assert_eq!(line, "sort: 0 of 10, 0/s, unknown left");
    }
}

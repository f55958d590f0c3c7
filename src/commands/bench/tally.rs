//! What was measured of one variant.

use flaneur_renderer::{FrameStats, PassTime};

use crate::evaluation::speed::ladder::Single;
use crate::evaluation::speed::{Difference, Inputs, Row, Unit, Variant, median, percentile};

/// Passes whose result is geometry.
const GEOMETRY: [&str; 3] = ["mesh", "points", "surface"];

/// Times, differences to the most exact frames, and what was drawn.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Milliseconds of the frame and of each pass, in the order of a frame.
    times: Vec<(&'static str, Vec<f64>)>,
    pub(super) difference: Difference,
    pub(super) stats: Vec<FrameStats>,
    /// What the renderer held on the device, at most.
    bytes: u64,
}

impl Tally {
    /// Adds the time of a frame, milliseconds.
    pub(super) fn add_frame(&mut self, ms: f64) {
        self.add(Row::FRAME, ms);
    }

    /// Adds what the renderer holds on the device after a frame, bytes.
    pub(super) fn add_bytes(&mut self, bytes: u64) {
        self.bytes = self.bytes.max(bytes);
    }

    /// Adds the times of the passes of one.
    pub(super) fn add_passes(&mut self, passes: &[PassTime]) {
        for pass in passes {
            self.add(pass.pass, pass.time.as_secs_f64() * 1e3);
        }
    }

    fn add(&mut self, pass: &'static str, ms: f64) {
        match self.times.iter_mut().find(|(name, _)| *name == pass) {
            Some((_, times)) => times.push(ms),
            None => self.times.push((pass, vec![ms])),
        }
    }

    /// Times of a pass, milliseconds.
    pub(super) fn times(&self, pass: &str) -> &[f64] {
        let found = self.times.iter().find(|(name, _)| *name == pass);
        found.map_or(&[], |(_, times)| times)
    }

    /// Their median.
    pub(super) fn median_ms(&self, pass: &str) -> Option<f64> {
        median(self.times(pass))
    }

    /// What the frame costs.
    pub(super) fn single(&self) -> Option<Single> {
        let (ms, mse) = (self.median_ms(Row::FRAME)?, self.difference.mean_squared_255()?);
        Some(Single { ms, mse, uncovered: self.difference.uncovered_share() })
    }

    /// A row for the frame, and one for each pass that was timed.
    pub(super) fn rows(&self, variant: &Variant) -> impl Iterator<Item = Row> {
        let counts = Inputs::mean(&self.stats);
        let (method, setting) = (variant.method, variant.setting.clone());
        self.times.iter().filter_map(move |(pass, times)| {
            let (error, error_rms, error_unit) = if GEOMETRY.contains(pass) {
                (self.difference.depths_m(), f64::NAN, Unit::Metres)
            } else {
                let mean = self.difference.mean_squared_255();
                (self.difference.colours_255(), mean.map_or(f64::NAN, f64::sqrt), Unit::Colour)
            };
            let [error_max, error_p99] = error.unwrap_or([f64::NAN; 2]);
            Some(Row {
                pass,
                method,
                setting: setting.clone(),
                ms_median: median(times)?,
                ms_p95: percentile(times, 0.95)?,
                error_max,
                error_p99,
                error_rms,
                error_unit,
                uncovered: self.difference.uncovered_share(),
                unmatched: self.difference.unmatched_share(),
                inputs: counts.to_string(),
                counts,
                bytes: (*pass == Row::FRAME).then_some(self.bytes),
                front: false,
                within_fifth: None,
                late: None,
            })
        })
    }
}

//! Amounts of memory as people write them.

use std::str::FromStr;

use clap::Args;
use flaneur_renderer::MemoryReport;
use flaneur_streamer::FetchLimits;
use serde::{Serialize, Serializer};

/// Memory that a command may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MemorySize(u64);

/// Below this, buffers of a few files leave no room for the data.
const MINIMUM: u64 = 64 << 20;

impl MemorySize {
    /// Its bytes.
    pub(crate) fn bytes(self) -> u64 {
        self.0
    }
}

/// Memory of the graphics device, and what a view may ask for so that it fits: what had to be
/// refused would have been fetched for nothing.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct GpuMemory {
    /// Hold at most so much of the graphics device's memory; what is far is given up first
    #[arg(long, value_name = "SIZE", default_value = "8GiB")]
    gpu_memory: MemorySize,
}

impl GpuMemory {
    /// Its bytes.
    pub(crate) fn bytes(self) -> u64 {
        self.gpu_memory.bytes()
    }

    /// `limits`, or what fits into the memory where that is less.
    pub(crate) fn fitted(self, limits: FetchLimits) -> FetchLimits {
        // See `Settings::gpu_memory_bytes`. With its levels a pixel takes 16 / 3 bytes; shelves
        // and blocks are never full.
        let (for_images, for_points) = (self.bytes() / 16 * 6, self.bytes() / 16 * 3);
        FetchLimits {
            image_pixels: limits.image_pixels.min(for_images / 8),
            points: limits.points.min(for_points / 24),
            ..limits
        }
    }
}

/// Bytes that renderers hold on the graphics device, by kind and in all, as reports give them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HeldMemory(pub(crate) MemoryReport);

impl HeldMemory {
    /// Takes `held` where that is more in all.
    pub(crate) fn raise_to(&mut self, held: MemoryReport) {
        if held.total() > self.0.total() {
            self.0 = held;
        }
    }
}

impl Serialize for HeldMemory {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.0.kinds().into_iter().chain([("total", self.0.total())]))
    }
}

impl FromStr for MemorySize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
        let (number, unit) = text.split_at(end);
        let unit: u64 = match unit.trim().to_ascii_lowercase().as_str() {
            "" | "b" => 1,
            "k" | "kib" => 1 << 10,
            "kb" => 1_000,
            "m" | "mib" => 1 << 20,
            "mb" => 1_000_000,
            "g" | "gib" => 1 << 30,
            "gb" => 1_000_000_000,
            "t" | "tib" => 1 << 40,
            "tb" => 1_000_000_000_000,
            other => {
                return Err(format!("{other:?} is no unit; write for instance 2GiB or 512MiB"));
            }
        };
        let number: f64 = number
            .parse()
            .map_err(|_| format!("{number:?} is no number; write for instance 2GiB"))?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "digits are never negative, and the cast saturates"
        )]
        let bytes = (number * unit as f64) as u64;
        if bytes < MINIMUM {
            return Err(format!("{text:?} is too little; the least is {}MiB", MINIMUM >> 20));
        }
        Ok(Self(bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_asks_for_no_more_than_fits() {
        let memory = |text: &str| GpuMemory { gpu_memory: text.parse().expect("an amount") };
        assert_eq!(memory("8GiB").fitted(FetchLimits::default()), FetchLimits::default());
        let fitted = memory("256MiB").fitted(FetchLimits::default());
        assert!(fitted.points * 16 < (256 << 20) * 3 / 16 && fitted.points > 1_000_000);
        assert!(fitted.image_pixels * 16 / 3 < (256 << 20) * 6 / 16);
    }

    #[test]
    fn amounts_are_read_with_their_units() {
        let bytes = |text: &str| text.parse::<MemorySize>().map(MemorySize::bytes);
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("512 MiB"), Ok(512 << 20));
        assert_eq!(bytes("1.5g"), Ok(3 << 29));
        assert_eq!(bytes("100MB"), Ok(100_000_000));
        assert_eq!(bytes("67108864"), Ok(64 << 20));
        for (text, problem) in
            [("10MiB", "least is 64MiB"), ("2GiBs", "no unit"), ("GiB", "no number"), ("-1", "")]
        {
            let error = bytes(text).expect_err(text);
            assert!(error.contains(problem), "{text}: {error}");
        }
    }
}

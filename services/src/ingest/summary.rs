//! What an ingest did.

use std::collections::BTreeMap;

use serde::Serialize;

/// The account of an ingest that succeeded.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// The store that it is in.
    pub store: String,
    /// Whether the same inputs had been published before, so that nothing was done.
    pub unchanged: bool,
    /// Points.
    pub points: u64,
    /// Footprints.
    pub footprints: u64,
    /// Panoramas.
    pub panoramas: u64,
    /// Photographs.
    pub images: u64,
    /// Number of warnings of each kind.
    pub warnings: BTreeMap<String, u64>,
    /// The warnings, `kind: message`; of a kind with very many, the first.
    pub warning_messages: Vec<String>,
    /// Bytes of all the scene's objects but its manifest.
    pub bytes: u64,
    /// Time that it took.
    pub seconds: f64,
    /// Points read and stored per second of the points' layers; 0 where none were made.
    pub points_per_second: f64,
    /// Most memory that the process held at a time, where the system tells.
    pub peak_memory_bytes: Option<u64>,
    /// Layers that an earlier, interrupted run had finished.
    pub layers_reused: Vec<String>,
}

/// Most memory that this process has held at a time, bytes.
pub(super) fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib << 10)
}

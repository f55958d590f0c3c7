//! What `--report` says.

use std::collections::BTreeMap;
use std::path::Path;

use flaneur_renderer::{Frame, PassTime, Renderer, Settings};
use serde::Serialize;

use crate::memory::HeldMemory;

/// All frames of a run. Times, counts and coverage are those of the last frame; every frame has
/// its own in `frames`.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    width: u32,
    height: u32,
    /// Name of the graphics adapter.
    adapter: String,
    /// From view to pixels in memory, once all is resident, milliseconds.
    frame_ms: f64,
    /// From the start of connecting to the first complete picture, milliseconds.
    first_frame_ms: f64,
    /// Bytes of all messages received from the data services.
    bytes_received: u64,
    /// Points resident.
    points: u64,
    /// Triangles resident.
    triangles: u64,
    /// Photographs resident.
    images: u64,
    /// Share of the pixels showing geometry that at least one photograph colours.
    coverage: f64,
    /// Bytes that the renderer holds on the device, by kind.
    memory: HeldMemory,
    frames: Vec<FrameReport>,
}

/// One frame.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FrameReport {
    file: String,
    width: u32,
    height: u32,
    frame_ms: f64,
    /// Milliseconds of each pass, each waited for before the next begins.
    passes: BTreeMap<&'static str, f64>,
    /// From the start of connecting to this picture, milliseconds.
    since_start_ms: f64,
    /// Bytes received until this picture.
    bytes_received: u64,
    points: u64,
    triangles: u64,
    images: u64,
    coverage: f64,
    /// Bytes that the renderer holds on the device, by kind.
    memory: HeldMemory,
    /// What a frame budget may have changed.
    settings: Quality,
}

/// Settings that trade speed for error between frames.
#[derive(Clone, Copy, Debug, Serialize)]
struct Quality {
    rigs: usize,
    /// `null` for no limit.
    frame_points: Option<u64>,
    inferred_hypotheses: u32,
    resolution: f32,
}

impl From<Settings> for Quality {
    fn from(settings: Settings) -> Self {
        let Settings { rigs, frame_points, inferred_hypotheses, resolution, .. } = settings;
        let frame_points = (frame_points < u64::MAX).then_some(frame_points);
        Self { rigs, frame_points, inferred_hypotheses, resolution }
    }
}

impl Report {
    /// The report of `frames` in their order, `None` where there are none.
    pub(crate) fn new(adapter: String, frames: Vec<FrameReport>) -> Option<Self> {
        let (first, last) = (frames.first()?, frames.last()?.clone());
        Some(Self {
            width: last.width,
            height: last.height,
            adapter,
            frame_ms: last.frame_ms,
            first_frame_ms: first.since_start_ms,
            bytes_received: last.bytes_received,
            points: last.points,
            triangles: last.triangles,
            images: last.images,
            coverage: last.coverage,
            memory: last.memory,
            frames,
        })
    }
}

impl FrameReport {
    pub(crate) fn new(
        file: &Path,
        frame: &Frame,
        frame_ms: f64,
        passes: &[PassTime],
        since_start_ms: f64,
        bytes_received: u64,
        renderer: &Renderer,
    ) -> Self {
        Self {
            file: file.display().to_string(),
            width: frame.size.x,
            height: frame.size.y,
            frame_ms,
            passes: passes.iter().map(|p| (p.pass, p.time.as_secs_f64() * 1e3)).collect(),
            since_start_ms,
            bytes_received,
            points: frame.stats.points,
            triangles: frame.stats.triangles,
            images: frame.stats.images,
            coverage: frame.stats.coverage(),
            memory: HeldMemory(renderer.memory()),
            settings: renderer.settings().into(),
        }
    }
}

//! What `--report` says.

use std::collections::BTreeMap;
use std::path::Path;

use flaneur_renderer::{BudgetStanding, Frame, PassTime, Renderer};
use serde::Serialize;

use crate::evaluation::StatedSettings;
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
    /// Share of all pixels that photographs colour at an inferred depth.
    inferred: f64,
    /// Bytes that the renderer holds on the device, by kind.
    memory: HeldMemory,
    /// How the frame budget fares, as of a frame.
    budget: Option<Budget>,
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
    /// Points of the chunks that meet the view.
    points_drawn: u64,
    /// Points left out since the run began: not finite, or too far from their origin.
    points_refused: u64,
    triangles: u64,
    /// Triangles of the tiles that meet the view.
    triangles_drawn: u64,
    /// Triangles left out since the run began: with a corner that is not finite.
    triangles_refused: u64,
    images: u64,
    coverage: f64,
    inferred: f64,
    /// Bytes that the renderer holds on the device, by kind.
    memory: HeldMemory,
    /// What a frame budget may have changed among them.
    settings: StatedSettings,
    /// How the frame budget fares; `null` without one, or where it has not come to rest.
    budget: Option<Budget>,
}

/// A time that frames were to take.
#[derive(Clone, Copy, Debug, Serialize)]
struct Budget {
    asked_ms: f64,
    /// Median of the last frames.
    reached_ms: f64,
    /// Whether those took no more than a fifth longer than asked.
    held: bool,
    /// Where the settings stand on the ladder, 0 the most exact, of so many: on the front, between
    /// its measured rungs, and below it with fewer points and pixels.
    rung: usize,
    rungs: usize,
}

impl From<BudgetStanding> for Budget {
    fn from(standing: BudgetStanding) -> Self {
        let BudgetStanding { asked, reached, held, rung, rungs } = standing;
        let [asked_ms, reached_ms] = [asked, reached].map(|time| time.as_secs_f64() * 1e3);
        Self { asked_ms, reached_ms, held, rung, rungs }
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
            inferred: last.inferred,
            memory: last.memory,
            budget: last.budget,
            frames,
        })
    }
}

impl FrameReport {
    #[expect(clippy::too_many_arguments, reason = "one argument a figure")]
    pub(crate) fn new(
        file: &Path,
        frame: &Frame,
        frame_ms: f64,
        passes: &[PassTime],
        since_start_ms: f64,
        bytes_received: u64,
        renderer: &Renderer,
        standing: Option<BudgetStanding>,
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
            points_drawn: frame.stats.points_drawn,
            points_refused: frame.stats.points_refused,
            triangles: frame.stats.triangles,
            triangles_drawn: frame.stats.triangles_drawn,
            triangles_refused: frame.stats.triangles_refused,
            images: frame.stats.images,
            coverage: frame.stats.coverage(),
            inferred: frame.stats.inferred_share(),
            memory: HeldMemory(renderer.memory()),
            settings: StatedSettings(renderer.settings()),
            budget: standing.map(Budget::from),
        }
    }
}

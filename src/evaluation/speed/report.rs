//! What a measurement of speed and error says.

use std::fmt;

use flaneur_renderer::{FrameStats, Settings};
use serde::Serialize;

use super::{Cost, OffScreen, Variant, mark_front};
use crate::evaluation::StatedSettings;
use crate::memory::HeldMemory;

/// A measurement.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    /// The scene's name.
    pub(crate) scene: String,
    /// Name of the graphics adapter.
    pub(crate) adapter: String,
    /// Whether the adapter is a program on the processor.
    pub(crate) software: bool,
    /// Processor cores that the process may use.
    pub(crate) cpus: usize,
    /// What was measured, and how.
    #[serde(flatten)]
    pub(crate) described: Described,
    /// Bytes that a renderer held on the device, at most; they follow each other.
    pub(crate) memory: HeldMemory,
    /// A row a variant and pass; the frame's own rows have the pass `frame`.
    pub(crate) rows: Vec<Row>,
    /// The front of frames over all settings that a frame budget changes, most exact first.
    pub(crate) front: Vec<FrontRung>,
    /// How costs grow with what is drawn.
    pub(crate) linearity: Linearity,
}

/// Settings such that none of those that were measured gives a frame that is both faster and nearer
/// to the most exact one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct FrontRung {
    /// Most rigs that colour a pixel.
    pub(crate) rigs: usize,
    /// Share of the points that a view meets.
    pub(crate) points_share: f32,
    /// Depths tried where nothing is known; `null` where such pixels stay empty.
    pub(crate) inferred_hypotheses: Option<u32>,
    /// Whether photographs are aligned.
    pub(crate) align: bool,
    /// Share of the picture's sides at which it is computed.
    pub(crate) resolution: f32,
    /// Median time of a frame, milliseconds.
    pub(crate) ms_median: f64,
    /// See [`Row::error_rms`].
    pub(crate) error_rms: f64,
    /// See [`Row::uncovered`].
    pub(crate) uncovered: f64,
}

/// What was measured, and how.
#[derive(Debug, Serialize)]
pub(crate) struct Described {
    /// Size of the pictures, pixels.
    pub(crate) width: u32,
    /// Size of the pictures, pixels.
    pub(crate) height: u32,
    /// How many views.
    pub(crate) views: usize,
    /// How often each was rendered by each variant.
    pub(crate) repeats: usize,
    /// The default settings of the renderer.
    pub(crate) settings: StatedSettings,
}

/// What a pass, or the whole frame, takes in one variant.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    /// Name of the pass, or `frame`.
    pub(crate) pass: &'static str,
    /// Which setting is traded for speed.
    pub(crate) method: &'static str,
    /// Its value.
    pub(crate) setting: String,
    /// Median over views and repeats, milliseconds.
    pub(crate) ms_median: f64,
    /// What 95 % of the times do not exceed, milliseconds.
    pub(crate) ms_p95: f64,
    /// Largest difference of a pixel to the most exact frame; `null` where there is nothing to
    /// compare.
    pub(crate) error_max: f64,
    /// What 99 % of the pixels do not exceed.
    pub(crate) error_p99: f64,
    /// Root of the mean square over the pixels; of colours alone.
    pub(crate) error_rms: f64,
    /// Unit of the three.
    pub(crate) error_unit: Unit,
    /// Share of the pixels that photographs colour in the most exact frame alone. Each counts as a
    /// difference of 255.
    pub(crate) uncovered: f64,
    /// Share of the pixels that show a surface in one of the frames alone.
    pub(crate) unmatched: f64,
    /// What was drawn, in words.
    pub(crate) inputs: String,
    /// What was drawn, on average over the views.
    #[serde(flatten)]
    pub(crate) counts: Inputs,
    /// Bytes that the renderer held on the device after it, at most over the views; of frames alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) bytes: Option<u64>,
    /// Whether no other variant's frame is both faster and nearer to the most exact one; of
    /// frames alone.
    pub(crate) front: bool,
    /// Share of the frames that took within a fifth of their budget; of budgets alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) within_fifth: Option<f64>,
    /// Share of the frames that took longer than that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) late: Option<f64>,
}

/// What an error is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) enum Unit {
    /// A colour, as a byte.
    #[serde(rename = "1/255")]
    Colour,
    /// Depth.
    #[serde(rename = "m")]
    Metres,
}

/// Means over views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Inputs {
    /// Points resident.
    pub(crate) points: f64,
    /// Points of the chunks that meet the view.
    pub(crate) points_drawn: f64,
    /// Triangles of the tiles that meet the view.
    pub(crate) triangles_drawn: f64,
    /// Photographs resident.
    pub(crate) images: f64,
    /// Photographs that may colour the view: of each of the nearest rigs, all cameras that see some
    /// of it.
    pub(crate) images_drawn: f64,
}

/// How costs grow with what is drawn.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Linearity {
    /// The points pass against points drawn.
    pub(crate) points: Vec<Cost>,
    /// Milliseconds at none, milliseconds a point, and the share of the variance explained.
    pub(crate) points_line: Option<[f64; 3]>,
    /// The photographs pass against photographs drawn.
    pub(crate) textures: Vec<Cost>,
    /// Milliseconds at none, milliseconds a photograph, and the share of the variance explained.
    pub(crate) textures_line: Option<[f64; 3]>,
    /// The same views with more resident that they do not see.
    pub(crate) off_screen: Vec<OffScreen>,
}

impl Report {
    /// The frames' rows.
    pub(crate) fn frames(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.pass == Row::FRAME)
    }

    /// Sets [`Row::front`] of every row: of the frame of each variant, by median time and
    /// [`Row::error_rms`]. Budgets show other views.
    pub(crate) fn mark_front(rows: &mut [Row]) {
        let competes = |row: &Row| row.pass == Row::FRAME && row.within_fifth.is_none();
        let frames: Vec<usize> = (0..rows.len()).filter(|&index| competes(&rows[index])).collect();
        let costs: Vec<[f64; 2]> =
            frames.iter().map(|&index| [rows[index].ms_median, rows[index].error_rms]).collect();
        for (index, front) in frames.into_iter().zip(mark_front(&costs)) {
            rows[index].front = front;
        }
    }
}

impl Row {
    /// The pass that stands for all of them.
    pub(crate) const FRAME: &'static str = "frame";
    /// The method of rows that compare with f64 instead of the most exact frame.
    pub(crate) const AGAINST_F64: &'static str = "against f64";

    /// What is varied, in one line.
    pub(crate) fn label(method: &str, setting: &str) -> String {
        if setting.is_empty() { method.to_owned() } else { format!("{method} {setting}") }
    }
}

impl Described {
    /// Of `views` pictures of the size of `settings`.
    pub(crate) fn new(size: glam::UVec2, views: usize, repeats: usize, settings: Settings) -> Self {
        let settings = StatedSettings(settings);
        Self { width: size.x, height: size.y, views, repeats, settings }
    }
}

impl Inputs {
    /// The means of several frames' counts.
    pub(crate) fn mean(frames: &[FrameStats]) -> Self {
        let mean = |of: fn(&FrameStats) -> u64| {
            frames.iter().map(|stats| of(stats) as f64).sum::<f64>() / frames.len().max(1) as f64
        };
        Self {
            points: mean(|stats| stats.points),
            points_drawn: mean(|stats| stats.points_drawn),
            triangles_drawn: mean(|stats| stats.triangles_drawn),
            images: mean(|stats| stats.images),
            images_drawn: mean(|stats| stats.images_drawn),
        }
    }
}

impl fmt::Display for Inputs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.0} points, {:.0} triangles, {:.0} photographs",
            self.points_drawn, self.triangles_drawn, self.images_drawn
        )
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Colour => "1/255",
            Self::Metres => "m",
        })
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&Row::label(self.method, &self.setting))
    }
}

//! How far a frame of the device is from its reference.

use glam::{DVec3, UVec2};

use super::{Pixel, ReferenceFrame};
use crate::Frame;

/// A neighbour's place this far out of a pixel's own plane lies beyond an edge where colours are
/// compared, metres.
pub(super) const STEP_M: f64 = 0.01;

/// Inferred depths that are in doubt by more than this share may rightly be others: on a wall 7 m away,
/// between photographs 3 m apart, it is a pixel.
pub(super) const DOUBT: f64 = 0.05;

/// Differences of colour away from edges, in 255ths: the largest of a pixel's channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Pixels of the picture.
    pub pixels: usize,
    /// Pixels that were compared.
    pub compared: usize,
    /// Of those, the share that differs by at most a 255th.
    pub alike: f64,
    /// Of those, the share that shows the same surface.
    pub same_surface: f64,
    /// Mean.
    pub mean_255: f64,
    /// What 99 % of the pixels stay within.
    pub p99_255: f64,
    /// The largest.
    pub max_255: f64,
}

impl ReferenceFrame {
    /// Which pixels lie on an edge of depth: one of the eight neighbours shows nothing where the
    /// pixel shows something, or the reverse, or a place that stands out of the pixel's own plane
    /// by more than `step_m`. There the device may rightly show either side.
    pub fn edges(&self, step_m: f64) -> Vec<bool> {
        let at = |x: u32, y: u32| &self.pixels[(y * self.size.x + x) as usize];
        let UVec2 { x: columns, y: rows } = self.size;
        let mut edges = Vec::with_capacity(self.pixels.len());
        for y in 0..rows {
            for x in 0..columns {
                let here = at(x, y);
                let mut around = (y.saturating_sub(1)..=(y + 1).min(rows - 1)).flat_map(|v| {
                    (x.saturating_sub(1)..=(x + 1).min(columns - 1)).map(move |u| (u, v))
                });
                edges.push(around.any(|(u, v)| parts(here, at(u, v), step_m)));
            }
        }
        edges
    }

    /// Compares the frame of the device with this one, away from edges of a centimetre and from inferred
    /// depths that are in doubt. The reference is rounded to bytes
    /// first, as the device's picture is.
    ///
    /// # Panics
    /// Where the two are not of one size.
    pub fn difference(&self, frame: &Frame) -> Difference {
        assert_eq!(frame.size, self.size, "frames of one view");
        let mut off: Vec<f64> = Vec::new();
        let mut same = 0;
        for (i, edge) in self.edges(STEP_M).into_iter().enumerate() {
            let pixel = &self.pixels[i];
            if edge || pixel.doubt > DOUBT {
                continue;
            }
            let bytes = &frame.rgba[4 * i..4 * i + 3];
            let found = DVec3::new(bytes[0].into(), bytes[1].into(), bytes[2].into());
            off.push((found - (pixel.rgb * 255.0).round()).abs().max_element());
            same += usize::from(frame.surfaces[i] == pixel.surface);
        }
        off.sort_by(f64::total_cmp);
        let compared = off.len();
        let share = |count: usize| count as f64 / compared.max(1) as f64;
        Difference {
            pixels: self.pixels.len(),
            compared,
            alike: share(off.partition_point(|&d| d <= 1.0)),
            same_surface: share(same),
            mean_255: off.iter().sum::<f64>() / compared.max(1) as f64,
            p99_255: off.get(compared * 99 / 100).copied().unwrap_or(0.0),
            max_255: off.last().copied().unwrap_or(0.0),
        }
    }
}

/// Whether an edge runs between two neighbours.
fn parts(here: &Pixel, there: &Pixel, step_m: f64) -> bool {
    match (here.place, there.place) {
        (Some(a), Some(b)) => a.normal.dot(b.position - a.position).abs() > step_m,
        (a, b) => a.is_some() != b.is_some(),
    }
}

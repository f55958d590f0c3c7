//! Frames that were on screen, kept in a temporary file until they are compared.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};

use flaneur_renderer::Frame;
use flaneur_scene::View;

use crate::exit::Exit;

/// Between two kept frames, seconds: a twentieth of the time that has passed, within these limits. What
/// is on screen changes fastest at the beginning.
const APART_S: [f64; 2] = [0.1, 1.0];

/// When a frame came on screen, and what was received by the time that its rendering began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shown {
    pub(super) view: View,
    pub(super) ms: f64,
    pub(super) bytes: u64,
}

/// The frames of a walk in the order of time, all of one size. They take three bytes a pixel of the
/// system's temporary folder, and no memory.
pub(super) struct Kept {
    file: File,
    frames: Vec<Shown>,
    frame_bytes: usize,
}

impl Kept {
    /// None yet.
    pub(super) fn new() -> Result<Self, Exit> {
        let file = tempfile::tempfile().map_err(failed)?;
        Ok(Self { file, frames: Vec::new(), frame_bytes: 0 })
    }

    /// Whether a frame that is shown now is to be kept.
    pub(super) fn is_due(&self, ms: f64) -> bool {
        let [least, most] = APART_S;
        let apart_ms = 1e3 * (ms / 20e3).clamp(least, most);
        self.frames.last().is_none_or(|last| ms - last.ms >= apart_ms)
    }

    /// Keeps a frame.
    pub(super) fn push(&mut self, frame: &Frame, shown: Shown) -> Result<(), Exit> {
        let rgb: Vec<u8> = frame.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        self.frame_bytes = rgb.len();
        self.file.write_all(&rgb).map_err(failed)?;
        self.frames.push(shown);
        Ok(())
    }

    /// All frames.
    pub(super) fn frames(&self) -> &[Shown] {
        &self.frames
    }

    /// The pixels of a frame, sRGB, three bytes each.
    pub(super) fn pixels(&mut self, index: usize) -> Result<Vec<u8>, Exit> {
        let mut rgb = vec![0; self.frame_bytes];
        let at = SeekFrom::Start(self.frame_bytes as u64 * index as u64);
        self.file.seek(at).and_then(|_| self.file.read_exact(&mut rgb)).map_err(failed)?;
        Ok(rgb)
    }
}

fn failed(error: std::io::Error) -> Exit {
    let what = "cannot keep frames in the temporary folder; make room there, or set TMPDIR";
    Exit::Failed(anyhow::Error::new(error).context(what))
}

#[cfg(test)]
mod tests {
    use flaneur_renderer::FrameStats;
    use glam::{DVec3, UVec2};

    use super::*;

    #[test]
    fn frames_come_back_as_they_were() {
        let mut kept = Kept::new().unwrap_or_else(|e| panic!("{e:?}"));
        let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::new(2, 1));
        let frame = |value: u8| Frame {
            size: UVec2::new(2, 1),
            rgba: vec![value, value + 1, value + 2, 255, value + 3, value + 4, value + 5, 255],
            surfaces: Vec::new(),
            stats: FrameStats::default(),
        };
        for (value, ms) in [(10, 500.0), (20, 610.0)] {
            assert!(kept.is_due(ms));
            kept.push(&frame(value), Shown { view, ms, bytes: 7 })
                .unwrap_or_else(|e| panic!("{e:?}"));
        }
        for (index, value) in [(1, 20), (0, 10)] {
            let pixels = kept.pixels(index).unwrap_or_else(|e| panic!("{e:?}"));
            assert_eq!(pixels, [0, 1, 2, 3, 4, 5].map(|i| value + i));
        }
        assert!(!kept.is_due(700.0) && kept.is_due(711.0));
        assert!(kept.pixels(2).is_err());
        kept.push(&frame(30), Shown { view, ms: 60e3, bytes: 7 })
            .unwrap_or_else(|e| panic!("{e:?}"));
        assert!(!kept.is_due(60.9e3) && kept.is_due(61.1e3), "once a second in the end");
    }
}

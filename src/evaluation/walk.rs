//! What a visitor saw, when, and for how many bytes.

use flaneur_renderer::FrameStats;
use flaneur_scene::SceneUpdate;
use serde::Serialize;

use super::StatedSettings;
use super::squared_error::{mean_squared_error, psnr_db};
use super::ssim::SsimMap;
use glam::UVec2;

/// The PSNR that stands for equal pictures, dB: above what any difference of a picture has.
const EQUAL_DB: f64 = 120.0;

/// A walk over a throttled connection. Times are milliseconds since connecting began; what did not
/// happen is `null`.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    /// When the first complete, if coarse, picture was on screen.
    pub(crate) first_picture_ms: Option<f64>,
    /// Bytes received when all that it takes had come.
    pub(crate) first_picture_bytes: Option<u64>,
    /// When what was on screen first had an SSIM of 0.90 to the same view fully loaded.
    pub(crate) ms_to_ssim_090: Option<f64>,
    /// The same for 0.95.
    pub(crate) ms_to_ssim_095: Option<f64>,
    /// Bytes that TCP carried to the visitor.
    pub(crate) bytes: u64,
    /// Bytes of those that no frame ever showed: of what was given up before it was whole, of what was
    /// damaged or came twice, and of what was not wanted any more when it came and never was again. With
    /// what the connection carried beside messages: parts that a request's end cut off, and what HTTP/2 adds.
    pub(crate) bytes_wasted: u64,
    /// Share of the tiles, images and nodes asked for that a cache held.
    pub(crate) cache_hit_rate: f64,
    /// Requests sent.
    pub(crate) requests: u64,
    /// Requests that a new view made useless, ended on the wire.
    pub(crate) cancelled: u64,
    /// The longest time from the beginning of a frame, when what has arrived is brought to the device,
    /// to its pixels.
    pub(crate) longest_frame_ms: Option<f64>,
    /// Frames that were on screen, in the order of time.
    pub(crate) samples: Vec<Sample>,
    /// What was asked for.
    pub(crate) settings: Asked,
    /// What it ran on.
    pub(crate) machine: Machine,
    /// Where the time to the first picture went.
    pub(crate) profile: Profile,
}

/// A frame that was on screen, against the same view fully loaded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Sample {
    /// When it came on screen.
    pub(crate) ms: f64,
    /// Bytes of messages received when its rendering began.
    pub(crate) bytes: u64,
    /// Structural similarity, 1 for equal pictures.
    pub(crate) ssim: f64,
    /// Peak signal-to-noise ratio, at most 120, which stands for equal pictures.
    pub(crate) psnr_db: f64,
}

/// What was asked for.
#[derive(Debug, Serialize)]
pub(crate) struct Asked {
    /// The scene's name.
    pub(crate) scene: String,
    /// Each way; `null` for no limit.
    pub(crate) bandwidth_bits_per_s: Option<f64>,
    /// Each way.
    pub(crate) latency_ms: f64,
    /// How long the walk takes from its first to its last view.
    pub(crate) walk_s: f64,
    /// Size of the pictures, pixels.
    pub(crate) width: u32,
    /// Size of the pictures, pixels.
    pub(crate) height: u32,
    /// The renderer's settings.
    pub(crate) renderer: StatedSettings,
}

/// What it ran on.
#[derive(Debug, Serialize)]
pub(crate) struct Machine {
    /// Name of the graphics adapter.
    pub(crate) adapter: String,
    /// Whether the adapter is a program on the processor.
    pub(crate) software: bool,
    /// Processor cores that the process may use; server, streamer and renderer share them.
    pub(crate) cpus: usize,
}

/// Kinds of updates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Mesh,
    Photographs,
    Points,
}

/// Where the time to the first picture went, and what the connection carried.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Profile {
    /// When the connection was there.
    pub(crate) connected_ms: Option<f64>,
    /// When it was known what the scene holds.
    pub(crate) scene_ms: Option<f64>,
    /// When the first and the last tile of mesh came to the renderer before the first picture.
    pub(crate) mesh_ms: Option<[f64; 2]>,
    /// The same of photographs.
    pub(crate) photographs_ms: Option<[f64; 2]>,
    /// The same of points.
    pub(crate) points_ms: Option<[f64; 2]>,
    /// How long the renderer took to take them, in all.
    pub(crate) applying_ms: f64,
    /// When rendering the first picture began.
    pub(crate) drawn_from_ms: Option<f64>,
    /// Triangles that it was made of.
    pub(crate) triangles: u64,
    /// Photographs.
    pub(crate) photographs: u64,
    /// Points.
    pub(crate) points: u64,
    /// Bytes that TCP carried to the visitor in all, with all that is added to messages.
    pub(crate) tcp_bytes_down: u64,
    /// Bytes that it carried to the server.
    pub(crate) tcp_bytes_up: u64,
}

impl Part {
    /// Which kind an update is of.
    pub(crate) fn of(update: &SceneUpdate) -> Self {
        match update {
            SceneUpdate::Mesh(_) | SceneUpdate::DropMesh(_) => Self::Mesh,
            SceneUpdate::Image(_) | SceneUpdate::DropImage(_) => Self::Photographs,
            SceneUpdate::Points(_) | SceneUpdate::DropPoints(_) => Self::Points,
        }
    }
}

impl Profile {
    /// Takes note of an update that came and how long the renderer took for it.
    pub(crate) fn came(&mut self, part: Part, at_ms: f64, took_ms: f64) {
        let span = match part {
            Part::Mesh => &mut self.mesh_ms,
            Part::Photographs => &mut self.photographs_ms,
            Part::Points => &mut self.points_ms,
        };
        *span = Some([span.map_or(at_ms, |[first, _]| first), at_ms]);
        self.applying_ms += took_ms;
    }

    /// Takes note of what the first picture was made of.
    pub(crate) fn drawn(&mut self, stats: &FrameStats, from_ms: f64) {
        self.drawn_from_ms = Some(from_ms);
        let FrameStats { triangles, images, points, .. } = *stats;
        (self.triangles, self.photographs, self.points) = (triangles, images, points);
    }
}

impl Sample {
    /// The frame `shown` against `whole`, sRGB of `size` with three bytes a pixel; `None` where that
    /// is smaller than a window of SSIM.
    pub(crate) fn new(
        ms: f64,
        bytes: u64,
        shown: &[u8],
        whole: &[u8],
        size: UVec2,
    ) -> Option<Self> {
        let ssim = SsimMap::new(shown, whole, size)?.mean();
        let psnr_db = psnr_db(mean_squared_error(shown, whole, |_| true)).min(EQUAL_DB);
        Some(Self { ms, bytes, ssim, psnr_db })
    }

    /// When the first of `samples` had such an SSIM.
    pub(crate) fn reached(samples: &[Self], ssim: f64) -> Option<f64> {
        samples.iter().find(|sample| sample.ssim >= ssim).map(|sample| sample.ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quality_is_reached_by_the_first_frame_that_has_it() {
        let sample = |ms: f64, ssim: f64| Sample { ms, bytes: 0, ssim, psnr_db: 20.0 };
        let samples =
            [sample(10.0, 0.5), sample(20.0, 0.92), sample(30.0, 0.85), sample(40.0, 0.93)];
        assert_eq!(Sample::reached(&samples, 0.9), Some(20.0));
        assert_eq!(Sample::reached(&samples, 0.95), None);
    }

    #[test]
    fn equal_pictures_have_figures_that_json_can_hold() {
        let (size, grey) = (UVec2::new(16, 8), [90; 3 * 16 * 8]);
        let equal = Sample::new(1.0, 2, &grey, &grey, size).expect("large enough");
        assert_eq!((equal.ssim, equal.psnr_db), (1.0, EQUAL_DB));
        let mut other = grey;
        other[0] += 1;
        let near = Sample::new(1.0, 2, &grey, &other, size).expect("large enough");
        assert!(near.ssim < 1.0 && near.psnr_db < EQUAL_DB, "{near:?}");
        assert!(Sample::new(1.0, 2, &grey, &grey, UVec2::new(64, 2)).is_none());
    }
}

//! What a client wants to see, checked.

use std::time::Duration;

use flaneur_proto::{FieldError, v1};
use flaneur_renderer::Mode;
use flaneur_scene::View;
use tokio::time::Instant;

use super::RenderOptions;
use crate::picture::PictureFormat;

/// Longest side of a picture, pixels: every device that renders holds pictures of as many.
const MAX_SIDE: u32 = 8192;

/// A view that waits to be shown.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    /// The client's number of it.
    pub(super) sequence: u64,
    /// The view as the client wrote it, which frames echo.
    pub(super) message: v1::View,
    pub(super) view: View,
    pub(super) mode: Mode,
    /// When it came.
    pub(super) since: Instant,
}

/// How its pictures are made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wish {
    encoding: v1::Encoding,
    jpeg_quality: Option<u8>,
    /// What a frame takes while the view moves.
    pub(super) budget: Option<Duration>,
}

impl Wanted {
    /// The view of a message, where it is in range and its picture not too large, or may shrink.
    pub(super) fn new(
        sequence: u64,
        message: v1::View,
        options: &RenderOptions,
    ) -> Result<Self, FieldError> {
        let message = if message.may_shrink { shrunk(message, options.pixels) } else { message };
        let view = View::try_from(&message)?;
        for (field, side) in [("width", message.width), ("height", message.height)] {
            if side > MAX_SIDE {
                let problem = format!("is {side}, must be at most {MAX_SIDE}");
                return Err(FieldError::new(field, problem));
            }
        }
        let pixels = u64::from(message.width) * u64::from(message.height);
        if pixels > options.pixels {
            let (width, height) = (message.width, message.height);
            let problem =
                format!("and height are {width}x{height}, {} pixels at most", options.pixels);
            return Err(FieldError::new("width", problem));
        }
        let mode = mode(message.mode).ok_or_else(|| {
            FieldError::new("mode", format!("is {}, which is no mode", message.mode))
        })?;
        Ok(Self { sequence, message, view, mode, since: Instant::now() })
    }
}

impl Wish {
    /// The wish of a message; that of an absent one is the default.
    pub(super) fn new(message: Option<&v1::Quality>) -> Result<Self, FieldError> {
        let Some(message) = message else { return Ok(Self::default()) };
        let encoding = v1::Encoding::try_from(message.encoding).map_err(|_| {
            FieldError::new("encoding", format!("is {}, which is none", message.encoding))
        })?;
        let jpeg_quality = match message.jpeg_quality {
            0 => None,
            quality @ 1..=100 => Some(quality as u8),
            other => {
                let problem = format!("is {other}, must be 1 to 100, or 0 for a suitable one");
                return Err(FieldError::new("jpeg_quality", problem));
            }
        };
        let ms = message.frame_budget_ms;
        if !(ms == 0.0 || (1.0..=60_000.0).contains(&ms)) {
            let problem = format!("is {ms}, must be 1 to 60000, or 0 for the server's own");
            return Err(FieldError::new("frame_budget_ms", problem));
        }
        let budget = (ms > 0.0).then(|| Duration::from_secs_f64(ms / 1e3));
        Ok(Self { encoding, jpeg_quality, budget })
    }

    /// The format of a picture for which JPEG would have the quality `suitable`.
    pub(super) fn format(&self, suitable: u8) -> PictureFormat {
        match self.encoding {
            v1::Encoding::Png => PictureFormat::Png,
            v1::Encoding::Webp => PictureFormat::WebP,
            v1::Encoding::Unspecified | v1::Encoding::Jpeg => {
                PictureFormat::Jpeg(self.jpeg_quality.unwrap_or(suitable))
            }
        }
    }
}

/// The view with at most `most` pixels, at least 1, and sides that a picture can have, of about the
/// same shape. One without any pixels stays as it is.
fn shrunk(view: v1::View, most: u64) -> v1::View {
    let [width, height] = [view.width, view.height].map(f64::from);
    let area = (most as f64 / (width * height)).sqrt();
    let scale = area.min(f64::from(MAX_SIDE) / width.max(height));
    if scale >= 1.0 || width * height == 0.0 {
        return view;
    }
    // At least one pixel; so the other side may have to give way.
    let width = ((width * scale) as u64).clamp(1, most);
    let height = ((height * scale) as u64).clamp(1, most / width);
    v1::View { width: width as u32, height: height as u32, ..view }
}

fn mode(number: i32) -> Option<Mode> {
    Some(match v1::Mode::try_from(number).ok()? {
        v1::Mode::Hybrid => Mode::Hybrid,
        v1::Mode::Mesh => Mode::Mesh,
        v1::Mode::Points => Mode::Points,
        v1::Mode::PointsColour => Mode::PointsColour,
        v1::Mode::Wireframe => Mode::Wireframe,
        v1::Mode::Depth => Mode::Depth,
        v1::Mode::Normals => Mode::Normals,
        v1::Mode::Sources => Mode::Sources,
        v1::Mode::Uncertainty => Mode::Uncertainty,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_may_shrink_keeps_its_shape_and_fits() {
        let shrunk = |width, height, most| {
            let view = shrunk(v1::View { width, height, ..v1::View::default() }, most);
            (view.width, view.height)
        };
        assert_eq!(shrunk(1280, 720, 1 << 20), (1280, 720), "it fits as it is");
        assert_eq!(shrunk(2000, 1000, 500_000), (1000, 500));
        assert_eq!(shrunk(81_920, 20, 1 << 20), (8192, 2), "no side is too long");
        assert_eq!(shrunk(0, u32::MAX, 10), (0, u32::MAX), "that is no picture");
        let long = u32::MAX;
        for (width, height) in [(1920, 1080), (1, long), (long, 1), (long, long), (3, 100_000)] {
            for most in [1, 10, 70_000, 1 << 25] {
                let (w, h) = shrunk(width, height, most);
                assert!(w >= 1 && h >= 1 && u64::from(w) * u64::from(h) <= most, "{w}x{h}");
                assert!(w.max(h) <= MAX_SIDE, "{w}x{h}");
            }
        }
        let (w, h) = shrunk(1920, 1080, 70_000);
        assert!((f64::from(w) / f64::from(h) - 16.0 / 9.0).abs() < 0.02, "{w}x{h}");
    }
}

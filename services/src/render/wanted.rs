//! What a client wants to see, checked.

use std::time::Duration;

use flaneur_proto::{FieldError, v1};
use flaneur_renderer::Mode;
use flaneur_scene::View;
use tokio::time::Instant;

use super::RenderOptions;
use crate::picture::PictureFormat;

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
    /// The view of a message, where it is in range and its picture not too large.
    pub(super) fn new(
        sequence: u64,
        message: v1::View,
        options: &RenderOptions,
    ) -> Result<Self, FieldError> {
        let view = View::try_from(&message)?;
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

//! Frames as picture files.

use std::io::Cursor;

use flaneur_renderer::Frame;
use image::codecs::png::PngEncoder;
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// JPEG of a quality from 1 to 100.
    Jpeg(u8),
    /// PNG, which keeps every pixel.
    Png,
    /// WebP without loss.
    WebP,
}

/// Why a frame could not be encoded.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// No JPEG has that many pixels.
    #[error("a JPEG has at most 65535 pixels a side, not {width}x{height}; choose PNG or WebP")]
    Side {
        /// Pixels of a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The encoder of a JPEG failed.
    #[error("cannot be encoded: {0}")]
    Jpeg(#[from] jpeg_encoder::EncodingError),
    /// That of another format failed.
    #[error("cannot be encoded: {0}")]
    Image(#[from] image::ImageError),
}

impl PictureFormat {
    /// Its media type.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Jpeg(_) => "image/jpeg",
            Self::Png => "image/png",
            Self::WebP => "image/webp",
        }
    }

    /// The file of a frame.
    ///
    /// # Errors
    /// Where the format cannot hold a picture of that size.
    pub fn encode(self, frame: &Frame) -> Result<Vec<u8>, PictureError> {
        let (width, height) = (frame.size.x, frame.size.y);
        if let Self::Jpeg(quality) = self {
            let side = |pixels: u32| {
                u16::try_from(pixels).map_err(|_| PictureError::Side { width, height })
            };
            let mut bytes = Vec::with_capacity(frame.rgba.len() / 16);
            let mut encoder = jpeg_encoder::Encoder::new(&mut bytes, quality.clamp(1, 100));
            encoder.set_sampling_factor(if quality < FULL_COLOUR {
                jpeg_encoder::SamplingFactor::F_2_2
            } else {
                jpeg_encoder::SamplingFactor::F_1_1
            });
            let colour = jpeg_encoder::ColorType::Rgba;
            encoder.encode(&frame.rgba, side(width)?, side(height)?, colour)?;
            return Ok(bytes);
        }
        let rgb: Vec<u8> = frame.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let mut bytes = Cursor::new(Vec::new());
        let colour = ExtendedColorType::Rgb8;
        match self {
            Self::WebP => {
                WebPEncoder::new_lossless(&mut bytes).write_image(&rgb, width, height, colour)?;
            }
            _ => PngEncoder::new(&mut bytes).write_image(&rgb, width, height, colour)?,
        }
        Ok(bytes.into_inner())
    }
}

/// From this quality on a JPEG has as many pixels of colour as of brightness.
const FULL_COLOUR: u8 = 88;

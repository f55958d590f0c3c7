//! Frames as picture files.

use std::io::Cursor;
use std::path::Path;

use flaneur_renderer::Frame;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};

use crate::exit::Exit;

/// Quality at which JPEG's errors are hard to see.
const JPEG_QUALITY: u8 = 92;

/// A file format, chosen by the name's extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    Png,
    Jpeg,
    WebP,
}

impl PictureFormat {
    /// The format that the extension of `path` names.
    pub(crate) fn of(path: &Path) -> Result<Self, Exit> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match extension.as_str() {
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            "webp" => Ok(Self::WebP),
            _ => Err(Exit::bad_input(anyhow::anyhow!(
                "a picture's name ends in .png, .jpg or .webp: {:?}",
                path.display()
            ))),
        }
    }

    /// The frame in this format; PNG and WebP keep every pixel.
    pub(crate) fn encode(self, frame: &Frame) -> Result<Vec<u8>, Exit> {
        let rgb: Vec<u8> = frame.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let mut bytes = Cursor::new(Vec::new());
        let (width, height, colour) = (frame.size.x, frame.size.y, ExtendedColorType::Rgb8);
        match self {
            Self::Png => PngEncoder::new(&mut bytes).write_image(&rgb, width, height, colour)?,
            Self::Jpeg => JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
                .write_image(&rgb, width, height, colour)?,
            Self::WebP => {
                WebPEncoder::new_lossless(&mut bytes).write_image(&rgb, width, height, colour)?;
            }
        }
        Ok(bytes.into_inner())
    }
}

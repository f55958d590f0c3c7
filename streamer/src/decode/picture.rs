//! Photographs and masks, as they are stored.

use std::io::Cursor;

use glam::UVec2;
use image::{ImageDecoder, ImageFormat, ImageReader};

use super::{Mask, damaged};
use crate::StreamError;

/// A decoded photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Size in pixels.
    pub size: UVec2,
    /// Red, green and blue, rows from the top.
    pub rgb: Vec<u8>,
}

/// The photograph in `bytes`, which must be of `size`.
pub(crate) fn decode_picture(
    what: &str,
    bytes: &[u8],
    size: UVec2,
) -> Result<Picture, StreamError> {
    let image = decode(what, bytes, |found| {
        (found == size).then_some(()).ok_or_else(|| format!("is {found}, must be {size} pixels"))
    })?;
    Ok(Picture { size, rgb: image.into_rgb8().into_raw() })
}

/// The first channel of the picture in `bytes`, at most `max_pixels` large, with its size.
pub(super) fn decode_grey(
    what: &str,
    bytes: &[u8],
    max_pixels: u64,
) -> Result<(UVec2, Vec<u8>), StreamError> {
    let image = decode(what, bytes, |found| {
        let pixels = u64::from(found.x) * u64::from(found.y);
        let fits = pixels > 0 && pixels <= max_pixels;
        fits.then_some(()).ok_or_else(|| format!("is {found}, at most {max_pixels} pixels"))
    })?;
    let grey = image.into_luma8();
    Ok((UVec2::new(grey.width(), grey.height()), grey.into_raw()))
}

/// Decodes after `accept` has seen the size, so that no memory is taken for a size that was
/// only claimed.
fn decode(
    what: &str,
    bytes: &[u8],
    accept: impl Fn(UVec2) -> Result<(), String>,
) -> Result<image::DynamicImage, StreamError> {
    // What a service calls it does not matter: the file says what it is.
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Jpeg | ImageFormat::Png)) => format,
        _ => return Err(damaged(what, "is neither a JPEG nor a PNG")),
    };
    let refuse = |e: image::ImageError| damaged(what, e.to_string());
    let decoder =
        ImageReader::with_format(Cursor::new(bytes), format).into_decoder().map_err(refuse)?;
    let (width, height) = decoder.dimensions();
    accept(UVec2::new(width, height)).map_err(|problem| damaged(what, problem))?;
    image::DynamicImage::from_decoder(decoder).map_err(refuse)
}

impl Picture {
    /// The picture with the alpha that `mask` gives it, see [`Mask::alpha`].
    pub(crate) fn masked(&self, mask: Option<&Mask>) -> Vec<u8> {
        let mut rgba = Vec::with_capacity(self.rgb.len() / 3 * 4);
        for pixel in self.rgb.chunks_exact(3) {
            rgba.extend_from_slice(&[pixel[0], pixel[1], pixel[2], 255]);
        }
        if let Some(mask) = mask {
            for (pixel, alpha) in rgba.chunks_exact_mut(4).zip(mask.alpha(self.size).iter()) {
                pixel[3] = *alpha;
            }
        }
        rgba
    }
}

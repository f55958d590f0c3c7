//! Image files: what their headers claim, and their pixels.

use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use glam::UVec2;
use image::{ImageDecoder, ImageFormat, ImageReader, Limits};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::files::unreadable;
use crate::ingest::{BadInput, IngestError};

/// An image file whose header has been read and is within the limits.
#[derive(Clone, Debug)]
pub(super) struct Photograph {
    path: PathBuf,
    format: ImageFormat,
    /// Width and height in pixels, as stored: orientation tags are ignored.
    pub(super) size: UVec2,
    /// Bytes that hold the file, its pixels and their pyramid while it is halved.
    pub(super) memory: u64,
    /// Size of the file.
    bytes: u64,
}

/// The most pixels that an image may have: a sphere of 23 000 × 11 500.
const MAX_PIXELS: u64 = 1 << 28;
/// The longest side: what a JPEG can hold.
const MAX_SIDE: u32 = 65_535;
/// The largest file.
const MAX_BYTES: u64 = 1 << 31;
/// Bytes a pixel for RGB, the linear half-size level, and what the encoder keeps of it.
const HALVING: u64 = 8;
/// Bytes a pixel for the coefficients of a JPEG that is not sequential.
const COEFFICIENTS: u64 = 6;

const RESAVE: &str = "restore it from the survey, or save it again as JPEG or PNG";

impl Photograph {
    /// Reads the header of an image. Errors name the file, and what its header claims.
    pub(super) fn inspect(path: &Path) -> Result<Self, IngestError> {
        let refuse =
            |problem: String, remedy: &str| BadInput::error(path, "", problem, remedy.to_owned());
        let mut file = BufReader::new(File::open(path).map_err(|e| unreadable(path, &e))?);
        let bytes = file.get_ref().metadata().map_err(|e| unreadable(path, &e))?.len();
        if bytes == 0 {
            return Err(refuse("it is empty".into(), "restore it from the survey"));
        }
        if bytes > MAX_BYTES {
            return Err(refuse(
                format!("it has {bytes} bytes, more than the {MAX_BYTES} that are read"),
                "save it with fewer pixels",
            ));
        }
        let mut start = [0; 16];
        let known = fill(&mut file, &mut start).map_err(|e| unreadable(path, &e))?;
        file.rewind().map_err(|e| unreadable(path, &e))?;
        let start = &start[..known];
        let format = image::guess_format(start).ok().filter(|format| {
            use ImageFormat::{Jpeg, Png, Tiff, WebP};
            matches!(format, Jpeg | Png | Tiff | WebP)
        });
        let Some(format) = format else {
            let problem = format!("it is no JPEG, PNG, TIFF or WebP: it begins with {start:02x?}");
            return Err(refuse(problem, RESAVE));
        };
        let damaged = |e: String| refuse(format!("its header is damaged: {e}"), RESAVE);
        let (size, decoded) = if format == ImageFormat::Jpeg {
            let mut decoder = JpegDecoder::new_with_options(file, strict());
            decoder.decode_headers().map_err(|e| damaged(e.to_string()))?;
            let info = decoder.info().ok_or_else(|| damaged("it has no frame".into()))?;
            let coefficients = if info.sof.is_sequential_dct() { 0 } else { COEFFICIENTS };
            (UVec2::new(info.width.into(), info.height.into()), coefficients)
        } else {
            let decoder = ImageReader::with_format(file, format).into_decoder();
            let decoder = decoder.map_err(|e| damaged(e.to_string()))?;
            let size = UVec2::from(decoder.dimensions());
            // The decoder's own pixels stand beside their RGB form.
            let pixels = u64::from(size.x) * u64::from(size.y);
            (size, decoder.total_bytes().div_ceil(pixels.max(1)))
        };
        let pixels = u64::from(size.x) * u64::from(size.y);
        let is_legal = pixels > 0 && pixels <= MAX_PIXELS && size.max_element() <= MAX_SIDE;
        if !is_legal {
            return Err(refuse(
                format!(
                    "its header claims {}×{} pixels; 1 to {MAX_PIXELS} are read, and {MAX_SIDE} \
                     in a row",
                    size.x, size.y
                ),
                "save it with fewer pixels",
            ));
        }
        let memory = bytes.saturating_add(pixels.saturating_mul(HALVING.saturating_add(decoded)));
        Ok(Self { path: path.to_owned(), format, size, memory, bytes })
    }

    /// Whether the file itself can be level 0.
    pub(super) fn is_jpeg(&self) -> bool {
        self.format == ImageFormat::Jpeg
    }

    /// The file's bytes.
    pub(super) fn read(&self) -> Result<Vec<u8>, IngestError> {
        let file = File::open(&self.path).map_err(|e| unreadable(&self.path, &e))?;
        let mut bytes = Vec::with_capacity(self.bytes as usize);
        file.take(self.bytes + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| unreadable(&self.path, &e))?;
        if bytes.len() as u64 == self.bytes { Ok(bytes) } else { Err(self.changed()) }
    }

    /// RGB samples of the file's bytes, row by row. A file that is cut short or does not
    /// decode to its last block is an error.
    pub(super) fn decode(&self, bytes: &[u8]) -> Result<Vec<u8>, IngestError> {
        let damaged = |e: String| {
            BadInput::error(&self.path, "", format!("it is damaged or cut short: {e}"), RESAVE)
        };
        let rgb = if self.is_jpeg() {
            let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), strict());
            decoder.decode_headers().map_err(|e| damaged(e.to_string()))?;
            if decoder.dimensions() != Some((self.size.x as usize, self.size.y as usize)) {
                return Err(self.changed());
            }
            if has_separate_subsampled_scans(bytes) {
                return Err(BadInput::error(
                    &self.path,
                    "",
                    "it holds its subsampled colours in separate scans, which is not supported",
                    "save it again as an ordinary or a progressive JPEG",
                ));
            }
            decoder.decode().map_err(|e| damaged(e.to_string()))?
        } else {
            let mut reader = ImageReader::with_format(Cursor::new(bytes), self.format);
            let mut limits = Limits::default();
            limits.max_image_width = Some(self.size.x);
            limits.max_image_height = Some(self.size.y);
            limits.max_alloc = Some(self.memory);
            reader.limits(limits);
            reader.decode().map_err(|e| damaged(e.to_string()))?.into_rgb8().into_raw()
        };
        let expected = 3 * self.size.x as usize * self.size.y as usize;
        if rgb.len() == expected {
            Ok(rgb)
        } else {
            Err(damaged(format!("{} samples instead of {expected}", rgb.len())))
        }
    }

    fn changed(&self) -> IngestError {
        BadInput::error(&self.path, "", "it changed while it was read", "ingest again")
    }
}

/// Strict, so that damage is an error and not a grey area; RGB whatever is stored.
fn strict() -> DecoderOptions {
    DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX))
        .jpeg_set_out_colorspace(ColorSpace::RGB)
}

/// Whether a sequential JPEG has subsampled components and does not interleave them. Such files
/// are legal and rare, and zune-jpeg gives wrong colours for them, here and in every client.
fn has_separate_subsampled_scans(jpeg: &[u8]) -> bool {
    let mut rest = jpeg.get(2..).unwrap_or_default();
    let mut is_subsampled = false;
    let mut components = 0;
    loop {
        // Fill bytes may precede a marker.
        while let [0xff, 0xff, ..] = rest {
            rest = &rest[1..];
        }
        let [0xff, marker, high, low, body @ ..] = rest else { return false };
        let length = usize::from(u16::from_be_bytes([*high, *low])).saturating_sub(2);
        let Some((segment, after)) = body.split_at_checked(length) else { return false };
        match marker {
            0xc0 | 0xc1 => {
                // Precision, height, width, and for each component identifier, sampling, table.
                let samplings = segment.get(6..).unwrap_or_default().chunks_exact(3);
                components = samplings.len();
                is_subsampled = samplings.map(|c| c[1]).any(|sampling| sampling != 0x11);
            }
            0xda => {
                let in_scan = segment.first().copied().map_or(0, usize::from);
                return is_subsampled && in_scan < components;
            }
            _ => {}
        }
        rest = after;
    }
}

/// Fills as much of `buffer` as the reader has.
fn fill(reader: &mut impl Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match reader.read(&mut buffer[filled..])? {
            0 => break,
            n => filled += n,
        }
    }
    Ok(filled)
}

#[cfg(test)]
mod tests;

//! Writing files below a folder, and reading back the one format that is our own choice.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use glam::UVec2;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::Value;

use crate::SampleError;

/// Quality of the photographs: enough that the truth is not lost in blocks.
const JPEG_QUALITY: u8 = 93;

/// A folder that is being filled.
#[derive(Clone, Debug)]
pub(crate) struct Folder {
    root: PathBuf,
}

impl Folder {
    /// The folder at `root`.
    pub(crate) fn new(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    /// Its path.
    pub(crate) fn path(&self) -> &Path {
        &self.root
    }

    /// Creates a folder below it.
    pub(crate) fn create(&self, name: &str) -> Result<(), SampleError> {
        let path = self.root.join(name);
        fs::create_dir_all(&path).map_err(|source| SampleError::Write { source, path })
    }

    /// Writes a file as it is.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), SampleError> {
        let path = self.root.join(name);
        fs::write(&path, bytes).map_err(|source| SampleError::Write { source, path })
    }

    /// Writes JSON: one entry a line where it is a list, so that it can be looked at.
    pub(crate) fn write_json(&self, name: &str, value: &Value) -> Result<(), SampleError> {
        let text = match value {
            Value::Array(entries) => {
                let lines: Vec<String> = entries.iter().map(Value::to_string).collect();
                format!("[\n{}\n]\n", lines.join(",\n"))
            }
            other => format!("{other}\n"),
        };
        self.write(name, text.as_bytes())
    }

    /// Writes a photograph, sRGB.
    pub(crate) fn write_jpeg(
        &self,
        name: &str,
        size: UVec2,
        rgb: &[u8],
    ) -> Result<(), SampleError> {
        self.write_image(name, |file| {
            JpegEncoder::new_with_quality(file, JPEG_QUALITY).write_image(
                rgb,
                size.x,
                size.y,
                ExtendedColorType::Rgb8,
            )
        })
    }

    /// Writes a PNG with one or three bytes a pixel.
    pub(crate) fn write_png(
        &self,
        name: &str,
        size: UVec2,
        pixels: &[u8],
    ) -> Result<(), SampleError> {
        let grey = pixels.len() == size.x as usize * size.y as usize;
        let colour = if grey { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
        self.write_image(name, |file| {
            PngEncoder::new(file).write_image(pixels, size.x, size.y, colour)
        })
    }

    /// Writes depths in metres as a NumPy array of shape (height, width), `<f4`.
    pub(crate) fn write_depths(
        &self,
        name: &str,
        size: UVec2,
        depths: &[f32],
    ) -> Result<(), SampleError> {
        let dictionary = format!(
            "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
            size.y, size.x
        );
        // Magic, version 1.0, length of the header; the whole padded to 64 bytes.
        let padding = (64 - (10 + dictionary.len() + 1) % 64) % 64;
        let header = format!("{dictionary}{}\n", " ".repeat(padding));
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        let length = u16::try_from(header.len()).expect("the header is below 200 bytes");
        bytes.extend(length.to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(depths.iter().flat_map(|depth| depth.to_le_bytes()));
        self.write(name, &bytes)
    }

    fn write_image(
        &self,
        name: &str,
        encode: impl FnOnce(&mut BufWriter<fs::File>) -> image::ImageResult<()>,
    ) -> Result<(), SampleError> {
        let path = self.root.join(name);
        let result = fs::File::create(&path).map_err(image::ImageError::IoError).and_then(|file| {
            let mut file = BufWriter::new(file);
            encode(&mut file)?;
            file.flush().map_err(image::ImageError::IoError)
        });
        result.map_err(|source| SampleError::Image { source, path })
    }
}

/// Reads depths as [`write_street`](crate::write_street) writes them: size, and metres
/// along the camera's axis, rows from the top, infinite where nothing is met.
pub fn read_depths(path: &Path) -> io::Result<(UVec2, Vec<f32>)> {
    let bad = || io::Error::new(io::ErrorKind::InvalidData, "not an array of this crate's making");
    let bytes = fs::read(path)?;
    let length = bytes.get(8..10).ok_or_else(bad)?;
    let start = 10 + usize::from(u16::from_le_bytes([length[0], length[1]]));
    let header = std::str::from_utf8(bytes.get(10..start).ok_or_else(bad)?).map_err(|_| bad())?;
    let shape = header.split(['(', ')']).nth(1).ok_or_else(bad)?;
    let sides: Vec<u32> = shape.split(',').filter_map(|side| side.trim().parse().ok()).collect();
    let &[height, width] = sides.as_slice() else { return Err(bad()) };
    let depths: Vec<f32> = bytes[start..]
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    let whole = depths.len() as u64 == u64::from(height) * u64::from(width);
    if whole { Ok((UVec2::new(width, height), depths)) } else { Err(bad()) }
}

//! `cameras.bin` and `images.bin`: little-endian records after a 64-bit count.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use super::ColmapImage;
use super::camera::{ColmapCamera, Model, lens};
use crate::ingest::panoramas::files::{open, unreadable};
use crate::ingest::{BadInput, IngestError, Job};

/// The cameras.
pub(super) fn cameras(file: &Path) -> Result<Vec<ColmapCamera>, IngestError> {
    // Identifier, model, width, height and three parameters at least.
    const SMALLEST: u64 = 4 + 4 + 8 + 8 + 3 * 8;
    let mut reader = Reader::open(file)?;
    let count = reader.count("cameras", SMALLEST)?;
    let mut cameras = Vec::with_capacity(count);
    for _ in 0..count {
        let start = reader.place();
        let id = u32::from_le_bytes(reader.take()?);
        let place = format!("{start}, camera {id}");
        let model = Model::by_number(u32::from_le_bytes(reader.take()?), file, &place)?;
        let size = [u64::from_le_bytes(reader.take()?), u64::from_le_bytes(reader.take()?)];
        let mut parameters = Vec::with_capacity(model.parameters());
        for _ in 0..model.parameters() {
            parameters.push(f64::from_le_bytes(reader.take()?));
        }
        cameras.push(ColmapCamera { id, lens: lens(model, size, &parameters, file, &place)? });
    }
    reader.end("cameras")?;
    Ok(cameras)
}

/// The images, without their points.
pub(super) fn images(job: &Job, file: &Path) -> Result<Vec<ColmapImage>, IngestError> {
    // Identifier, pose, camera, the name's end, and the number of points.
    const SMALLEST: u64 = 4 + 7 * 8 + 4 + 1 + 8;
    // Two coordinates and the point's identifier.
    const POINT: u64 = 24;
    let mut reader = Reader::open(file)?;
    let count = reader.count("images", SMALLEST)?;
    let mut images = Vec::with_capacity(count);
    for _ in 0..count {
        job.check()?;
        let start = reader.place();
        let id = u32::from_le_bytes(reader.take()?);
        let mut pose = [0.0; 7];
        for value in &mut pose {
            *value = f64::from_le_bytes(reader.take()?);
        }
        let [qw, qx, qy, qz, tx, ty, tz] = pose;
        let camera_id = u32::from_le_bytes(reader.take()?);
        let name = reader.name()?;
        let points = reader.count("points", POINT)? as u64;
        reader.skip(points * POINT)?;
        images.push(ColmapImage {
            name,
            camera_id,
            quaternion: [qw, qx, qy, qz],
            translation: [tx, ty, tz],
            place: format!("{start}, image {id}"),
        });
    }
    reader.end("images")?;
    Ok(images)
}

/// A file read front to back that knows how much is left.
struct Reader<'a> {
    file: &'a Path,
    reader: BufReader<File>,
    offset: u64,
    size: u64,
}

/// Longest name of an image.
const MAX_NAME: usize = 4096;

impl<'a> Reader<'a> {
    fn open(file: &'a Path) -> Result<Self, IngestError> {
        let opened = open(file)?;
        let size = opened.metadata().map_err(|e| unreadable(file, &e))?.len();
        Ok(Self { file, reader: BufReader::new(opened), offset: 0, size })
    }

    fn place(&self) -> String {
        format!("byte {}", self.offset)
    }

    fn damaged(&self, problem: String) -> IngestError {
        BadInput::error(self.file, self.place(), problem, "export the model from COLMAP again")
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], IngestError> {
        let mut bytes = [0; N];
        if self.size - self.offset < N as u64 {
            let left = self.size - self.offset;
            return Err(
                self.damaged(format!("the file is cut short: {N} bytes wanted, {left} left"))
            );
        }
        self.reader.read_exact(&mut bytes).map_err(|e| unreadable(self.file, &e))?;
        self.offset += N as u64;
        Ok(bytes)
    }

    /// A count of records of at least `smallest` bytes, checked against what is left.
    fn count(&mut self, what: &str, smallest: u64) -> Result<usize, IngestError> {
        let start = self.offset;
        let count = u64::from_le_bytes(self.take()?);
        let left = self.size - self.offset;
        if count > left / smallest {
            self.offset = start;
            return Err(self.damaged(format!(
                "{count} {what} of at least {smallest} bytes each do not fit into the {left} left"
            )));
        }
        usize::try_from(count).map_err(|_| self.damaged(format!("{count} {what} are too many")))
    }

    /// A name that ends with a zero byte.
    fn name(&mut self) -> Result<String, IngestError> {
        let start = self.offset;
        let mut name = Vec::new();
        loop {
            match self.take()? {
                [0] => break,
                [byte] if name.len() < MAX_NAME => name.push(byte),
                _ => {
                    self.offset = start;
                    return Err(self.damaged(format!("a name of more than {MAX_NAME} bytes")));
                }
            }
        }
        String::from_utf8(name).map_err(|e| {
            self.offset = start;
            self.damaged(format!(
                "the name {:?} is no UTF-8",
                String::from_utf8_lossy(e.as_bytes())
            ))
        })
    }

    fn skip(&mut self, bytes: u64) -> Result<(), IngestError> {
        let distance = i64::try_from(bytes)
            .map_err(|_| self.damaged(format!("{bytes} bytes are too many to skip")))?;
        self.reader.seek_relative(distance).map_err(|e| unreadable(self.file, &e))?;
        self.offset += bytes;
        Ok(())
    }

    /// After the last record nothing may follow: something was misread.
    fn end(&self, what: &str) -> Result<(), IngestError> {
        let left = self.size - self.offset;
        if left == 0 {
            Ok(())
        } else {
            Err(self.damaged(format!("{left} bytes follow the {what}")))
        }
    }
}

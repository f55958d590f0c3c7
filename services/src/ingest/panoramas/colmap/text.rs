//! `cameras.txt` and `images.txt`: lines of words, `#` begins a comment.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::ColmapImage;
use super::camera::{ColmapCamera, Model, lens};
use crate::ingest::panoramas::files::{open, unreadable};
use crate::ingest::{BadInput, IngestError, Job};

/// The cameras: `CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]`.
pub(super) fn cameras(job: &Job, file: &Path) -> Result<Vec<ColmapCamera>, IngestError> {
    const REMEDY: &str = "give CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]";
    let mut lines = Lines::open(file)?;
    let mut cameras = Vec::new();
    while let Some(line) = lines.next_record()? {
        job.check()?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let [id, model, width, height, parameters @ ..] = words.as_slice() else {
            return Err(lines.refuse("too few words for a camera".into(), REMEDY));
        };
        let id = lines.number(id, "the camera's identifier", REMEDY)?;
        let place = format!("{}, camera {id}", lines.place());
        let model = Model::by_name(model, file, &place)?;
        let size = [
            lines.number(width, "the width", REMEDY)?,
            lines.number(height, "the height", REMEDY)?,
        ];
        let parameters = parameters
            .iter()
            .map(|word| lines.number(word, "a parameter", REMEDY))
            .collect::<Result<Vec<f64>, _>>()?;
        cameras.push(ColmapCamera { id, lens: lens(model, size, &parameters, file, &place)? });
    }
    Ok(cameras)
}

/// The images: `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`, each followed by a line of
/// points, which may be empty and is skipped.
pub(super) fn images(job: &Job, file: &Path) -> Result<Vec<ColmapImage>, IngestError> {
    const REMEDY: &str = "give IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME";
    let mut lines = Lines::open(file)?;
    let mut images = Vec::new();
    while let Some(line) = lines.next_record()? {
        job.check()?;
        let mut rest = line.as_str();
        let mut words = [""; 9];
        for word in &mut words {
            rest = rest.trim_start();
            let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
            (*word, rest) = rest.split_at(end);
        }
        let name = rest.trim().to_owned();
        if name.is_empty() {
            return Err(lines.refuse("too few words for an image".into(), REMEDY));
        }
        let [id, pose @ .., camera] = words;
        let id: u32 = lines.number(id, "the image's identifier", REMEDY)?;
        let camera_id = lines.number(camera, "the camera's identifier", REMEDY)?;
        let mut numbers = [0.0; 7];
        for (number, word) in numbers.iter_mut().zip(pose) {
            *number = lines.number(word, "a number of the pose", REMEDY)?;
        }
        let [qw, qx, qy, qz, tx, ty, tz] = numbers;
        images.push(ColmapImage {
            name,
            camera_id,
            quaternion: [qw, qx, qy, qz],
            translation: [tx, ty, tz],
            place: format!("{}, image {id}", lines.place()),
        });
        lines.skip_points()?;
    }
    Ok(images)
}

/// The lines of a file, numbered.
struct Lines<'a> {
    file: &'a Path,
    reader: BufReader<File>,
    line: u64,
}

/// Longest line of a camera or an image.
const MAX_LINE: u64 = 64 << 10;

impl<'a> Lines<'a> {
    fn open(file: &'a Path) -> Result<Self, IngestError> {
        Ok(Self { file, reader: BufReader::new(open(file)?), line: 0 })
    }

    fn place(&self) -> String {
        format!("line {}", self.line)
    }

    fn refuse(&self, problem: String, remedy: &str) -> IngestError {
        BadInput::error(self.file, self.place(), problem, remedy)
    }

    fn number<T: std::str::FromStr>(
        &self,
        word: &str,
        what: &str,
        remedy: &str,
    ) -> Result<T, IngestError> {
        word.parse().map_err(|_| self.refuse(format!("{what} is {word:?}"), remedy))
    }

    /// The next line that is neither empty nor a comment.
    fn next_record(&mut self) -> Result<Option<String>, IngestError> {
        loop {
            self.line += 1;
            let mut bytes = Vec::new();
            let read = (&mut self.reader).take(MAX_LINE + 1).read_until(b'\n', &mut bytes);
            if read.map_err(|e| unreadable(self.file, &e))? == 0 {
                return Ok(None);
            }
            if bytes.len() as u64 > MAX_LINE {
                return Err(self.refuse(
                    format!("the line is longer than {MAX_LINE} bytes"),
                    "give one camera or image a line",
                ));
            }
            let line = String::from_utf8(bytes)
                .map_err(|_| self.refuse("it is no UTF-8".into(), "save the file as UTF-8"))?;
            let line = line.trim();
            if !line.is_empty() && !line.starts_with('#') {
                return Ok(Some(line.to_owned()));
            }
        }
    }

    /// Skips a line of points, however long: X Y POINT3D_ID for each. What is no multiple of
    /// three words is an image line: tools that leave the points out lose every other image.
    fn skip_points(&mut self) -> Result<(), IngestError> {
        self.line += 1;
        let (mut words, mut in_word) = (0_u64, false);
        loop {
            let buffer = self.reader.fill_buf().map_err(|e| unreadable(self.file, &e))?;
            let end = buffer.iter().position(|&b| b == b'\n');
            let line = &buffer[..end.unwrap_or(buffer.len())];
            for byte in line {
                let is_word = !byte.is_ascii_whitespace();
                words += u64::from(is_word && !in_word);
                in_word = is_word;
            }
            let used = end.map_or(buffer.len(), |end| end + 1);
            let done = end.is_some() || buffer.is_empty();
            self.reader.consume(used);
            if done {
                break;
            }
        }
        if words.is_multiple_of(3) {
            return Ok(());
        }
        Err(self.refuse(
            format!("{words} words where the points of the image above belong"),
            "follow every image line with a line of X Y POINT3D_ID triples, or an empty one",
        ))
    }
}

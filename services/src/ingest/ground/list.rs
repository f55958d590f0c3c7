//! A list of heights: `[{"e": …, "n": …, "h": …}, …]`, metres, in the scene's CRS.

use std::fmt;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::DVec3;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};

use crate::ingest::{BadInput, IngestError, Job};

/// Coordinates beyond this, in metres, are no place on Earth.
const FARTHEST_M: f64 = 1e8;

/// The heights listed in the file at `path`; at least one.
///
/// # Errors
///
/// Names the line where the file stops being such a list, the first height that is out of range,
/// or a list longer than the memory budget allows.
pub(super) fn read(job: &Job, path: &Path) -> Result<Vec<DVec3>, IngestError> {
    const REMEDY: &str = r#"write it as [{"e": easting, "n": northing, "h": height}, …], metres"#;
    let file = File::open(path).map_err(|error| {
        BadInput::error(path, "", error.to_string(), "check the path of [ground]")
    })?;
    let mut source = serde_json::Deserializer::from_reader(BufReader::new(file));
    let most = usize::try_from(job.memory / 8).unwrap_or(usize::MAX) / size_of::<DVec3>();
    let samples = source
        .deserialize_seq(List { most })
        .and_then(|samples| source.end().map(|()| samples))
        .map_err(|error| BadInput::json(path, &error, REMEDY))?;
    let far = |sample: &DVec3| !sample.abs().cmple(DVec3::splat(FARTHEST_M)).all();
    if let Some(index) = samples.iter().position(far) {
        let problem = format!("{} is out of range", samples[index]);
        return Err(BadInput::error(path, format!("height {index}"), problem, REMEDY));
    }
    if samples.is_empty() {
        return Err(BadInput::error(path, "", "the list is empty", REMEDY));
    }
    Ok(samples)
}

#[derive(Deserialize)]
struct Sample {
    e: f64,
    n: f64,
    h: f64,
}

/// Collects samples, but not more than `most`.
struct List {
    most: usize,
}

impl<'de> Visitor<'de> for List {
    type Value = Vec<DVec3>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of heights")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut samples = Vec::new();
        while let Some(Sample { e, n, h }) = list.next_element()? {
            if samples.len() >= self.most {
                return Err(A::Error::custom(format!(
                    "more than {} heights do not fit into an eighth of --memory",
                    self.most
                )));
            }
            samples.push(DVec3::new(e, n, h));
        }
        Ok(samples)
    }
}

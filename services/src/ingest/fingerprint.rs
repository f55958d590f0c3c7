//! Fingerprints: what a layer is made from, in 32 bytes.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Serialize;
use serde_json::Value;

use super::{BadInput, IngestError, Job, Stage, Unit};

/// Version of what the layers make of their inputs. Raise it when the same inputs give other
/// outputs, so that scenes are made anew.
const FORMAT: u32 = 6;

/// Bytes read at a time: enough for all cores to share the hashing.
const BLOCK: usize = 4 << 20;

/// Collects what a layer is made from. The order of calls matters.
pub(super) struct Fingerprint(blake3::Hasher);

/// The files that were read, as they were then.
#[derive(Default)]
pub(super) struct Inputs(Vec<(PathBuf, u64, Option<SystemTime>)>);

impl Fingerprint {
    /// The fingerprint of the layer `name`, of nothing so far.
    pub(super) fn new(name: &str) -> Self {
        let mut fingerprint = Self(blake3::Hasher::new());
        fingerprint.field(&FORMAT.to_le_bytes());
        fingerprint.field(name.as_bytes());
        fingerprint
    }

    /// Adds settings. Paths in them count relative to `folder`, so that a survey may move.
    pub(super) fn settings(&mut self, settings: &impl Serialize, folder: &Path) {
        let mut value = serde_json::to_value(settings).unwrap_or(Value::Null);
        make_relative(&mut value, &folder.to_string_lossy());
        self.field(value.to_string().as_bytes());
    }

    /// Adds another fingerprint, or any text.
    pub(super) fn text(&mut self, text: &str) {
        self.field(text.as_bytes());
    }

    /// Adds the names (relative to `folder`) and contents of files.
    pub(super) fn files(
        &mut self,
        files: &[PathBuf],
        folder: &Path,
        job: &Job,
        stage: &dyn Stage,
        inputs: &mut Inputs,
    ) -> Result<(), IngestError> {
        for file in files {
            let name = file.strip_prefix(folder).unwrap_or(file);
            self.field(name.to_string_lossy().as_bytes());
            let hash = hash_file(file, job, stage).map_err(|error| match error {
                HashError::Stopped(error) => error,
                HashError::Io(error) => unreadable(file, &error),
            })?;
            self.field(hash.as_bytes());
            inputs.note(file)?;
        }
        Ok(())
    }

    /// The fingerprint, 64 hexadecimal digits.
    pub(super) fn finish(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }

    fn field(&mut self, bytes: &[u8]) {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }
}

impl Inputs {
    fn note(&mut self, file: &Path) -> Result<(), IngestError> {
        let meta = std::fs::metadata(file).map_err(|error| unreadable(file, &error))?;
        self.0.push((file.to_owned(), meta.len(), meta.modified().ok()));
        Ok(())
    }

    /// Bytes of all files.
    pub(super) fn bytes(files: &[PathBuf]) -> u64 {
        files.iter().filter_map(|file| std::fs::metadata(file).ok()).map(|meta| meta.len()).sum()
    }

    /// An error where a file was altered since it was read: the scene would be neither the
    /// old survey nor the new one.
    pub(super) fn check_unaltered(&self) -> Result<(), IngestError> {
        for (file, size, modified) in &self.0 {
            let meta = std::fs::metadata(file).map_err(|error| unreadable(file, &error))?;
            if meta.len() != *size || meta.modified().ok() != *modified {
                return Err(BadInput::error(
                    file,
                    "",
                    "it was altered while it was ingested",
                    "run the same command again once nothing writes to it",
                ));
            }
        }
        Ok(())
    }
}

/// BLAKE3 of a file of the work folder, hexadecimal.
pub(super) fn content_hash(file: &Path, job: &Job) -> Result<String, IngestError> {
    match hash_file(file, job, &super::NoProgress) {
        Ok(hash) => Ok(hash.to_hex().to_string()),
        Err(HashError::Stopped(error)) => Err(error),
        Err(HashError::Io(error)) => Err(IngestError::io("read", file, error)),
    }
}

/// The stage that shows how far the hashing of `total` bytes is.
pub(super) fn stage(job: &Job, total: u64) -> Box<dyn Stage> {
    job.stage("compare inputs", total, Unit::Bytes)
}

enum HashError {
    Stopped(IngestError),
    Io(std::io::Error),
}

fn hash_file(file: &Path, job: &Job, stage: &dyn Stage) -> Result<blake3::Hash, HashError> {
    let mut reader = File::open(file).map_err(HashError::Io)?;
    let mut hasher = blake3::Hasher::new();
    let mut block = Vec::new();
    loop {
        job.check().map_err(HashError::Stopped)?;
        block.clear();
        let n =
            reader.by_ref().take(BLOCK as u64).read_to_end(&mut block).map_err(HashError::Io)?;
        if n == 0 {
            return Ok(hasher.finalize());
        }
        hasher.update_rayon(&block);
        stage.advance(n as u64);
    }
}

fn unreadable(file: &Path, error: &std::io::Error) -> IngestError {
    let remedy = "check its permissions, or remove it from the survey";
    BadInput::error(file, "", format!("cannot be read: {error}"), remedy)
}

/// Takes `folder` off the front of every text.
fn make_relative(value: &mut Value, folder: &str) {
    match value {
        Value::String(text) => {
            if let Some(rest) = text.strip_prefix(folder)
                && (rest.is_empty() || rest.starts_with('/'))
            {
                *text = format!(".{rest}");
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| make_relative(item, folder)),
        Value::Object(map) => map.values_mut().for_each(|item| make_relative(item, folder)),
        Value::Null | Value::Bool(_) | Value::Number(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(folder: &Path, setting: &str) -> String {
        let job = Job::new(folder, 1 << 20);
        let mut inputs = Inputs::default();
        let mut fingerprint = Fingerprint::new("points");
        fingerprint.settings(&serde_json::json!({"at": folder, "setting": setting}), folder);
        let files = [folder.join("a"), folder.join("b")];
        fingerprint
            .files(&files, folder, &job, &super::super::NoProgress, &mut inputs)
            .expect("readable");
        inputs.check_unaltered().expect("unaltered");
        fingerprint.finish()
    }

    #[test]
    fn contents_names_and_settings_count_but_not_the_place() {
        let (one, two) = (tempfile::tempdir().expect("dir"), tempfile::tempdir().expect("dir"));
        for folder in [&one, &two] {
            std::fs::write(folder.path().join("a"), "x").expect("file");
            std::fs::write(folder.path().join("b"), "yz").expect("file");
        }
        let first = of(one.path(), "s");
        assert_eq!(first, of(two.path(), "s"), "the survey moved");
        assert_ne!(first, of(one.path(), "t"), "another setting");
        std::fs::write(two.path().join("a"), "xy").expect("file");
        std::fs::write(two.path().join("b"), "z").expect("file");
        assert_ne!(first, of(two.path(), "s"), "the same bytes, cut elsewhere");
    }

    #[test]
    fn files_altered_meanwhile_are_named() {
        let folder = tempfile::tempdir().expect("dir");
        let file = folder.path().join("a");
        std::fs::write(&file, "x").expect("file");
        let mut inputs = Inputs::default();
        inputs.note(&file).expect("readable");
        std::fs::write(&file, "xx").expect("file");
        let error = inputs.check_unaltered().expect_err("altered").to_string();
        assert!(error.contains("/a: it was altered"), "{error}");
    }
}

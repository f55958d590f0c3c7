//! The work folder: what is finished there survives a kill and is used by the next run.
//!
//! ```text
//! {base}/{hash of store and scene}/
//!   lock                     held by the running ingest
//!   {layer}-{fingerprint}/   files of a layer
//!     layer.json             its result, written last: no record, no layer
//! ```

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{IngestError, Job, Warnings};

/// The work folder of one scene, locked. Removed only by [`Workspace::remove`].
pub(super) struct Workspace {
    folder: PathBuf,
    _lock: File,
}

/// A layer's result with what was noticed on the way.
pub(super) struct Finished<T> {
    /// What the layer gave.
    pub(super) result: T,
    /// What it could not use.
    pub(super) warnings: Warnings,
    /// Whether it was found finished.
    pub(super) reused: bool,
}

/// `layer.json`.
#[derive(Serialize, Deserialize)]
struct Record<T> {
    fingerprint: String,
    result: T,
    warnings: Warnings,
    /// Every file of the layer and its size: a record that outlived its files is no use.
    files: Vec<(PathBuf, u64)>,
}

const RECORD: &str = "layer.json";
const LOCK: &str = "lock";

/// Hexadecimal digits of a fingerprint in a folder's name.
const SHORT: usize = 16;

impl Workspace {
    /// The folder for `scene` of `store` below `base`, made where it does not exist.
    pub(super) fn open(base: &Path, store: &str, scene: &str) -> Result<Self, IngestError> {
        let folder = scene_folder(base, store, scene);
        let path = folder.join(LOCK);
        loop {
            std::fs::create_dir_all(&folder)
                .map_err(|error| IngestError::io("make", &folder, error))?;
            let lock = match File::create(&path) {
                Ok(lock) => lock,
                // Removed by another ingest between the two calls.
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
                Err(error) => return Err(IngestError::io("make", &path, error)),
            };
            match lock.try_lock() {
                Ok(()) => {}
                Err(std::fs::TryLockError::WouldBlock) => {
                    return Err(IngestError::Busy { scene: scene.to_owned(), folder });
                }
                Err(std::fs::TryLockError::Error(error)) => {
                    return Err(IngestError::io("lock", &path, error));
                }
            }
            // The lock may be that of a folder that its owner has just removed.
            if is_at(&lock, &path) {
                return Ok(Self { folder, _lock: lock });
            }
        }
    }

    /// The folder that a run left which was killed after it had published, where there is one
    /// and no other ingest works in it.
    pub(super) fn left_over(base: &Path, store: &str, scene: &str) -> Option<Self> {
        let exists = scene_folder(base, store, scene).exists();
        exists.then(|| Self::open(base, store, scene).ok()).flatten()
    }

    /// Removes what belongs to none of `layers` (names and fingerprints), to give its space
    /// back.
    pub(super) fn keep_only(&self, layers: &[(&str, &str)]) -> Result<(), IngestError> {
        let keep: Vec<PathBuf> =
            layers.iter().map(|(name, fingerprint)| self.layer_folder(name, fingerprint)).collect();
        let entries = std::fs::read_dir(&self.folder)
            .map_err(|error| IngestError::io("read", &self.folder, error))?;
        for entry in entries {
            let path = entry.map_err(|error| IngestError::io("read", &self.folder, error))?.path();
            if path.is_dir() && !keep.contains(&path) {
                remove(&path)?;
            }
        }
        Ok(())
    }

    /// The result of the layer, from an earlier run where that finished it, else from `make`,
    /// which is given a job with a folder of its own: empty, or with what a run that did not
    /// finish left there, made from the same inputs.
    pub(super) fn layer<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        fingerprint: &str,
        job: &Job,
        make: impl FnOnce(&Job) -> Result<T, IngestError>,
    ) -> Result<Finished<T>, IngestError> {
        job.check()?;
        let folder = self.layer_folder(name, fingerprint);
        if let Some(record) = finished(&folder, fingerprint) {
            return Ok(Finished { result: record.result, warnings: record.warnings, reused: true });
        }
        if folder.join(RECORD).exists() {
            // Its files are not what it says.
            remove(&folder)?;
        }
        std::fs::create_dir_all(&folder)
            .map_err(|error| IngestError::io("make", &folder, error))?;
        let layer = job.layer(folder.clone());
        let result = make(&layer)?;
        job.check()?;
        let files =
            files_below(&folder).map_err(|error| IngestError::io("read", &folder, error))?;
        let warnings = layer.warnings();
        let record = Record { fingerprint: fingerprint.to_owned(), result, warnings, files };
        write_record(&folder, &record)?;
        Ok(Finished { result: record.result, warnings: record.warnings, reused: false })
    }

    /// Removes the folder and everything in it.
    pub(super) fn remove(self) -> Result<(), IngestError> {
        remove(&self.folder)
    }

    fn layer_folder(&self, name: &str, fingerprint: &str) -> PathBuf {
        self.folder.join(format!("{name}-{}", fingerprint.get(..SHORT).unwrap_or(fingerprint)))
    }
}

fn scene_folder(base: &Path, store: &str, scene: &str) -> PathBuf {
    let mut hasher = blake3::Hasher::new();
    hasher.update(store.as_bytes()).update(b"\0").update(scene.as_bytes());
    base.join(hasher.finalize().to_hex().get(..SHORT).unwrap_or_default())
}

/// The record of a finished layer whose files are all there.
fn finished<T: DeserializeOwned>(folder: &Path, fingerprint: &str) -> Option<Record<T>> {
    let text = std::fs::read(folder.join(RECORD)).ok()?;
    let record: Record<T> = serde_json::from_slice(&text).ok()?;
    let intact = record.files.iter().all(|(name, size)| {
        std::fs::metadata(folder.join(name)).is_ok_and(|meta| meta.len() == *size)
    });
    Some(record).filter(|record| intact && record.fingerprint == fingerprint)
}

/// Writes the record beside its place, then moves it there: it is whole or not there.
fn write_record<T: Serialize>(folder: &Path, record: &Record<T>) -> Result<(), IngestError> {
    let path = folder.join(RECORD);
    let failed = |error| IngestError::io("write", &path, error);
    let text = serde_json::to_vec(record).map_err(|error| failed(error.into()))?;
    let beside = folder.join("layer.json.new");
    let mut file = File::create(&beside).map_err(failed)?;
    file.write_all(&text).and_then(|()| file.sync_all()).map_err(failed)?;
    std::fs::rename(&beside, &path).map_err(failed)
}

/// Relative paths and sizes of all files below a folder.
fn files_below(folder: &Path) -> std::io::Result<Vec<(PathBuf, u64)>> {
    let mut files = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(relative) = folders.pop() {
        for entry in std::fs::read_dir(folder.join(&relative))? {
            let entry = entry?;
            let path = relative.join(entry.file_name());
            let meta = entry.metadata()?;
            if meta.is_dir() {
                folders.push(path);
            } else {
                files.push((path, meta.len()));
            }
        }
    }
    files.sort();
    Ok(files)
}

fn remove(folder: &Path) -> Result<(), IngestError> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(IngestError::io("remove", folder, error))
        }
        _ => Ok(()),
    }
}

/// Whether the open file is the one at `path`.
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finished_layers_are_reused_and_damaged_ones_made_again() {
        let base = tempfile::tempdir().expect("dir");
        let job = Job::new(base.path(), 1 << 20);
        let make = |job: &Job| {
            std::fs::write(job.work.join("out"), "data").expect("file");
            job.warn("kind", "w");
            Ok(job.work.join("out"))
        };
        let work = Workspace::open(base.path(), "store", "scene").expect("free");
        let first = work.layer("l", "0123", &job, make).expect("made");
        assert!(!first.reused && first.result.is_file());
        drop(work);
        let work = Workspace::open(base.path(), "store", "scene").expect("free");
        let again = work.layer("l", "0123", &job, make).expect("found");
        assert!(again.reused);
        assert_eq!((&again.result, &again.warnings), (&first.result, &first.warnings));
        assert!(!work.layer("l", "4567", &job, make).expect("other fingerprint").reused);
        std::fs::write(&first.result, "cut").expect("file");
        assert!(!work.layer("l", "0123", &job, make).expect("a file was cut").reused);
        work.keep_only(&[("l", "4567")]).expect("removed");
        assert!(!first.result.exists());
        assert!(work.layer("l", "4567", &job, make).expect("kept").reused);
        work.remove().expect("removed");
        assert_eq!(std::fs::read_dir(base.path()).expect("dir").count(), 0);
    }

    #[test]
    fn a_failed_layer_is_not_recorded() {
        let base = tempfile::tempdir().expect("dir");
        let job = Job::new(base.path(), 1 << 20);
        let work = Workspace::open(base.path(), "store", "scene").expect("free");
        let failed = work.layer::<()>("l", "0", &job, |job| {
            std::fs::write(job.work.join("half"), "data").expect("file");
            Err(IngestError::Cancelled)
        });
        assert!(failed.is_err());
        let found = |job: &Job| Ok(job.work.join("half").exists());
        let made = work.layer("l", "0", &job, found).expect("made");
        assert!(!made.reused && made.result, "what was left can be taken up");
        assert!(!work.layer("l", "1", &job, found).expect("made").result, "of other inputs");
    }

    #[test]
    fn two_at_a_time_are_refused() {
        let base = tempfile::tempdir().expect("dir");
        let first = Workspace::open(base.path(), "store", "scene").expect("free");
        Workspace::open(base.path(), "store", "other").expect("another scene");
        let error = Workspace::open(base.path(), "store", "scene").err().expect("busy").to_string();
        assert!(error.contains("another ingest"), "{error}");
        assert!(Workspace::left_over(base.path(), "store", "scene").is_none(), "in use");
        drop(first);
        Workspace::left_over(base.path(), "store", "scene").expect("left").remove().expect("gone");
        assert!(Workspace::left_over(base.path(), "store", "scene").is_none(), "removed");
        Workspace::open(base.path(), "store", "scene").expect("free again");
    }
}

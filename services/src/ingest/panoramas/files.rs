//! Reading small files whole, and which of the listed images exist.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use flaneur_scene::StoredImage;

use super::draft::Draft;
use crate::ingest::{BadInput, IngestError, Job};

/// The bytes of a list, calibration or model. It may take a quarter of the memory budget.
pub(super) fn read_whole(job: &Job, path: &Path) -> Result<Vec<u8>, IngestError> {
    let limit = job.memory / 4;
    let mut bytes = Vec::new();
    let file = open(path)?;
    // One byte more than allowed, so that a file that grows or lies about its size is caught.
    file.take(limit + 1).read_to_end(&mut bytes).map_err(|e| unreadable(path, &e))?;
    if bytes.len() as u64 > limit {
        return Err(BadInput::error(
            path,
            "",
            format!("it is larger than {} MiB, a quarter of the memory budget", limit >> 20),
            "raise --memory or split the file",
        ));
    }
    Ok(bytes)
}

/// Opens a file that must exist.
pub(super) fn open(path: &Path) -> Result<File, IngestError> {
    File::open(path).map_err(|e| unreadable(path, &e))
}

/// A file that cannot be opened or read.
pub(super) fn unreadable(path: &Path, error: &std::io::Error) -> IngestError {
    BadInput::error(
        path,
        "",
        format!("cannot be read: {error}"),
        "check its path in street.toml and its permissions",
    )
}

/// Writes a file that is either whole or absent, with the folders above it.
pub(super) fn write_finished(file: &Path, bytes: &[u8]) -> Result<(), IngestError> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder).map_err(|e| io("create", folder, e))?;
    }
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = file.with_file_name(name);
    fs::write(&part, bytes).map_err(|e| io("write", &part, e))?;
    fs::rename(&part, file).map_err(|e| io("rename", &part, e))
}

/// What a client is told of a file of the work folder.
pub(super) fn stored_image(path: &Path) -> Result<StoredImage, IngestError> {
    let mut file = File::open(path).map_err(|e| io("read", path, e))?;
    let (mut bytes, mut hasher) = (0, crc32fast::Hasher::new());
    let mut block = vec![0; 1 << 16];
    loop {
        match file.read(&mut block).map_err(|e| io("read", path, e))? {
            0 => return Ok(StoredImage { bytes, crc32: hasher.finalize() }),
            n => {
                hasher.update(&block[..n]);
                bytes += n as u64;
            }
        }
    }
}

/// A file of the work folder that could not be handled.
pub(super) fn io(action: &'static str, path: &Path, source: std::io::Error) -> IngestError {
    IngestError::Io {
        action,
        path: path.to_owned(),
        source,
        remedy: "free some space, or give another work folder".into(),
    }
}

/// The drafts of one entry without the cameras whose image is absent: each of those is a
/// warning, and an error where nothing is left, since then the path is at fault.
pub(super) fn keep_existing(job: &Job, drafts: Vec<Draft>) -> Result<Vec<Draft>, IngestError> {
    let mut first_absent = None;
    let mut absent = 0_u64;
    let mut kept = Vec::with_capacity(drafts.len());
    for mut draft in drafts {
        job.check()?;
        draft.cameras.retain(|camera| {
            if camera.image.is_file() {
                return true;
            }
            job.warn(
                "absent-image",
                format!(
                    "{}, {}: the image of camera {} is absent: {}",
                    draft.file.display(),
                    draft.place,
                    camera.id,
                    camera.image.display()
                ),
            );
            absent += 1;
            if first_absent.is_none() {
                first_absent =
                    Some((draft.file.clone(), draft.place.clone(), camera.image.clone()));
            }
            false
        });
        if !draft.cameras.is_empty() {
            kept.push(draft);
        }
    }
    match first_absent {
        Some((file, place, image)) if kept.is_empty() => Err(BadInput::error(
            &file,
            place,
            format!("all {absent} images are absent, the first is {}", image.display()),
            "check the path of the images in street.toml",
        )),
        _ => Ok(kept),
    }
}

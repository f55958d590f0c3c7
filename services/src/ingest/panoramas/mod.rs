//! Photographs with poses: from a survey's rigs and panoramas to pyramids and a pose table.
//!
//! Each format ([`itowns`], [`colmap`], [`equirectangular`]) is read into [`draft`]s: poses and
//! lenses as published, and where the image files ought to be. Then the files that exist are
//! hashed, checked and halved ([`pyramid`]), in parallel within the memory budget, and the
//! table of [`crate::layers::panoramas`] is written.
//!
//! Decisions:
//! - A JPEG original is level 0 byte for byte. Other formats are stored as JPEG of quality 95,
//!   and a warning says how many were.
//! - Orientation tags (EXIF) are ignored: poses and calibrations refer to the raster as stored.
//! - Absent images are warnings, unless every image of an entry is absent. Damaged images and
//!   masks are errors, or warnings with `--skip-damaged`; a damaged list of poses, calibration
//!   or model is always an error, for nothing could be kept of its entry.

mod budget;
mod colmap;
mod csv;
mod draft;
mod equirectangular;
mod files;
mod itowns;
mod mask;
mod photograph;
mod pose;
mod pyramid;
mod rotation;
mod stage;

use std::collections::HashMap;
use std::path::PathBuf;

use flaneur_scene::Bounds3;
use serde::{Deserialize, Serialize};

use super::street::PanoramasSpec;
use super::{BadInput, IngestError, Job};
use crate::crs::Crs;
use draft::Draft;

/// The panoramas of a scene, ready in the work folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StagedPanoramas {
    /// The pose table, a FlatGeobuf; see [`crate::layers::panoramas`].
    pub table: PathBuf,
    /// Number of panoramas with at least one image.
    pub panoramas: u64,
    /// Number of photographs.
    pub images: u64,
    /// Box of the rigs' origins.
    pub bounds: Bounds3,
    /// Every object besides the table: its path below the scene's prefix, and its file in
    /// the work folder.
    pub objects: Vec<(String, PathBuf)>,
}

/// Reads every entry and stages what it holds below the job's work folder; `None` where
/// there are no entries, or no image is left of them.
///
/// # Errors
///
/// Bad input names file, place and remedy; see the module's decisions for what is a warning.
pub fn ingest_panoramas(
    job: &Job,
    specs: &[PanoramasSpec],
    crs: &Crs,
) -> Result<Option<StagedPanoramas>, IngestError> {
    let mut drafts = Vec::new();
    for spec in specs {
        job.check()?;
        let entry = match spec {
            PanoramasSpec::Itowns(spec) => itowns::read(job, spec, crs)?,
            PanoramasSpec::Colmap(spec) => colmap::read(job, spec)?,
            PanoramasSpec::Equirectangular(spec) => equirectangular::read(job, spec, crs)?,
        };
        drafts.extend(files::keep_existing(job, entry)?);
    }
    refuse_duplicates(&drafts)?;
    if drafts.is_empty() {
        return Ok(None);
    }
    stage::stage(job, &drafts, crs)
}

fn refuse_duplicates(drafts: &[Draft]) -> Result<(), IngestError> {
    let mut seen: HashMap<&str, &Draft> = HashMap::new();
    for draft in drafts {
        if let Some(first) = seen.insert(&draft.id, draft) {
            return Err(BadInput::error(
                &draft.file,
                &draft.place,
                format!(
                    "a second panorama {:?}; the first is {} of {}",
                    draft.id,
                    first.place,
                    first.file.display()
                ),
                "give every panorama of the street a name of its own",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;

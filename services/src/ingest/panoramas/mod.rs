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
//! - Poses are corrected where the photographs clearly disagree with them ([`refine`]).
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
mod refine;
mod rotation;
mod stage;

use std::collections::HashMap;
use std::path::PathBuf;

use flaneur_scene::Bounds3;
use serde::{Deserialize, Serialize};

use super::street::PanoramasSpec;
use super::{BadInput, IngestError, Job};
use crate::crs::Crs;
use crate::layers::delivered;
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
    /// The file of the poses as they were delivered, where they are corrected; see
    /// [`crate::layers::delivered`].
    pub delivered: Option<PathBuf>,
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
    let mut corrected = Vec::new();
    for spec in specs {
        job.check()?;
        let (entry, refine_poses) = match spec {
            PanoramasSpec::Itowns(spec) => (itowns::read(job, spec, crs)?, spec.refine_poses),
            PanoramasSpec::Colmap(spec) => (colmap::read(job, spec)?, spec.refine_poses),
            PanoramasSpec::Equirectangular(spec) => (equirectangular::read(job, spec, crs)?, false),
        };
        let mut entry = files::keep_existing(job, entry)?;
        if refine_poses {
            corrected.extend(refine::refine(job, &mut entry)?);
        }
        drafts.extend(entry);
    }
    refuse_duplicates(&drafts)?;
    if drafts.is_empty() {
        return Ok(None);
    }
    let Some(mut staged) = stage::stage(job, &drafts, crs)? else { return Ok(None) };
    if !corrected.is_empty() {
        let path = job.work.join("panoramas.delivered.json");
        let bytes = delivered::encode(&corrected)
            .map_err(|e| files::io("write", &path, std::io::Error::other(e)))?;
        files::write_finished(&path, &bytes)?;
        staged.delivered = Some(path);
    }
    Ok(Some(staged))
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

//! The parallel part: every image hashed, checked, halved and written to the work folder.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use flaneur_scene::{Bounds3, Panorama, Projection, RigCamera, StoredImage};
use glam::UVec2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::StagedPanoramas;
use super::budget::{Budget, over_budget};
use super::draft::{Draft, DraftCamera, DraftLens, DraftMask};
use super::files::{io, stored_image, write_finished};
use super::mask::{self, StagedMask};
use super::photograph::Photograph;
use super::pyramid::{self, SrgbTable};
use crate::crs::Crs;
use crate::ingest::{BadInput, IngestError, Job, Unit};
use crate::layers::panoramas::{image_path, mask_path, write};

/// Hexadecimal digits of an image's version.
const VERSION_DIGITS: usize = 8;

/// Stages the images of the drafts and writes the pose table; `None` where every image was
/// damaged and skipped.
///
/// An image is found finished by its record, which is written after its levels: a second run
/// over the same work folder hashes the originals and does no more.
pub(super) fn stage(
    job: &Job,
    drafts: &[Draft],
    crs: &Crs,
) -> Result<Option<StagedPanoramas>, IngestError> {
    let budget = Budget::new(job.memory);
    let masks = stage_masks(job, &budget, drafts)?;
    let images: Vec<(&Draft, &DraftCamera)> =
        drafts.iter().flat_map(|d| d.cameras.iter().map(move |c| (d, c))).collect();
    let progress = job.stage("images", images.len() as u64, Unit::Images);
    let table = SrgbTable::new();
    let failed = AtomicBool::new(false);
    let staged: Vec<Option<Result<StagedCamera, IngestError>>> = images
        .par_iter()
        .map(|(draft, camera)| {
            if failed.load(Ordering::Relaxed) {
                return None;
            }
            let mask = camera.mask.as_ref().and_then(|mask| masks.get(mask));
            let staged = stage_image(job, &budget, &table, &draft.id, camera, mask);
            let stops = match &staged {
                Ok(_) => false,
                Err(error) => !(job.skip_damaged && matches!(error, IngestError::BadInput(_))),
            };
            failed.fetch_or(stops, Ordering::Relaxed);
            progress.advance(1);
            Some(staged)
        })
        .collect();
    let mut staged = staged.into_iter();
    let mut objects = BTreeMap::new();
    let mut panoramas = Vec::with_capacity(drafts.len());
    let mut images = 0;
    for draft in drafts {
        let mut cameras = Vec::with_capacity(draft.cameras.len());
        for (camera, result) in draft.cameras.iter().zip(staged.by_ref()) {
            match result {
                Some(Ok(StagedCamera { rig_camera, files, recompressed })) => {
                    if recompressed {
                        let image = camera.image.display();
                        let message = format!("{image}: it is no JPEG and is stored as one");
                        job.warn("recompressed-image", message);
                    }
                    for (level, file) in (0..).zip(files) {
                        let path =
                            image_path(&draft.id, &rig_camera.id, &rig_camera.version, level);
                        objects.insert(path, file);
                    }
                    cameras.push(rig_camera);
                }
                Some(Err(IngestError::BadInput(bad))) if job.skip_damaged => {
                    job.warn("damaged-image", bad.to_string());
                }
                Some(Err(error)) => return Err(error),
                // Left out because another failed, which is reported when its turn comes.
                None => {}
            }
        }
        images += cameras.len() as u64;
        if !cameras.is_empty() {
            panoramas.push(panorama(draft, cameras));
        }
    }
    job.check()?;
    if panoramas.is_empty() {
        return Ok(None);
    }
    for mask in masks.values() {
        objects.insert(mask_path(&mask.mask.name), mask.file.clone());
    }
    let mut bounds = Bounds3::EMPTY;
    panoramas.iter().for_each(|panorama| bounds.include(panorama.position));
    let table = job.work.join("panoramas.fgb");
    let mut bytes = Vec::new();
    write(&mut bytes, &panoramas, crs.epsg())
        .map_err(|e| io("write", &table, std::io::Error::other(e)))?;
    write_finished(&table, &bytes)?;
    Ok(Some(StagedPanoramas {
        table,
        panoramas: panoramas.len() as u64,
        images,
        bounds,
        delivered: None,
        objects: objects.into_iter().collect(),
    }))
}

fn panorama(draft: &Draft, cameras: Vec<RigCamera>) -> Panorama {
    Panorama {
        id: draft.id.clone(),
        position: draft.position,
        world_from_rig: draft.world_from_rig,
        time: draft.time.clone(),
        uncertainty_m: draft.uncertainty_m,
        cameras,
    }
}

/// The masks of the drafts; an absent one is a warning, and its cameras go without.
fn stage_masks<'a>(
    job: &Job,
    budget: &Budget,
    drafts: &'a [Draft],
) -> Result<HashMap<&'a DraftMask, StagedMask>, IngestError> {
    let mut masks = HashMap::new();
    let mut left_out: Vec<&DraftMask> = Vec::new();
    for mask in drafts.iter().flat_map(|d| &d.cameras).filter_map(|c| c.mask.as_ref()) {
        if masks.contains_key(mask) || left_out.contains(&mask) {
            continue;
        }
        job.check()?;
        if !mask.image.is_file() {
            job.warn("absent-mask", format!("a mask is absent: {}", mask.image.display()));
            left_out.push(mask);
            continue;
        }
        match mask::stage(job, budget, mask) {
            Ok(staged) => {
                masks.insert(mask, staged);
            }
            Err(IngestError::BadInput(bad)) if job.skip_damaged => {
                job.warn("damaged-mask", bad.to_string());
                left_out.push(mask);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(masks)
}

/// A camera whose levels lie in the work folder.
struct StagedCamera {
    rig_camera: RigCamera,
    /// Its levels, from the finest.
    files: Vec<PathBuf>,
    /// The original is no JPEG, so level 0 is not the original's bytes.
    recompressed: bool,
}

/// What is written beside the levels once they are whole.
#[derive(Serialize, Deserialize)]
struct Finished {
    size: UVec2,
    levels: u32,
}

fn stage_image(
    job: &Job,
    budget: &Budget,
    table: &SrgbTable,
    panorama: &str,
    camera: &DraftCamera,
    mask: Option<&StagedMask>,
) -> Result<StagedCamera, IngestError> {
    job.check()?;
    let photograph = Photograph::inspect(&camera.image)?;
    let projection = projection(camera, photograph.size)?;
    if let Some(mask) = mask
        && !same_proportions(mask.size, photograph.size)
    {
        return Err(BadInput::error(
            &camera.image,
            "",
            format!("it is {} pixels, but its mask is {}", by(photograph.size), by(mask.size)),
            "give a mask of the same proportions",
        ));
    }
    let _share = budget
        .take(photograph.memory)
        .ok_or_else(|| over_budget(&camera.image, photograph.memory, budget))?;
    job.check()?;
    let bytes = photograph.read()?;
    let mut hasher = blake3::Hasher::new();
    hasher.update(pyramid::ENCODER_VERSION.as_bytes()).update(&bytes);
    let original = hasher.finalize().to_hex();
    let level_file =
        |level| job.work.join(image_path(panorama, &camera.id, &original[..VERSION_DIGITS], level));
    let levels = pyramid::level_count(photograph.size);
    let record = level_file(0).with_file_name("finished.json");
    if !is_finished(&record, photograph.size, levels, &level_file) {
        let failed = |e: String| io("encode", &camera.image, std::io::Error::other(e));
        let rgb = photograph.decode(&bytes)?;
        if photograph.is_jpeg() {
            write_finished(&level_file(0), &bytes)?;
        } else {
            let jpeg = pyramid::encode_original(photograph.size, &rgb).map_err(failed)?;
            write_finished(&level_file(0), &jpeg)?;
        }
        let mut half = None;
        for level in 1..levels {
            job.check()?;
            let next = match &half {
                None => pyramid::halve_srgb(photograph.size, &rgb),
                Some(above) => pyramid::LinearImage::halve(above),
            };
            write_finished(&level_file(level), &next.encode(table).map_err(failed)?)?;
            half = Some(next);
        }
        let finished = Finished { size: photograph.size, levels };
        let json = serde_json::to_vec(&finished).map_err(|e| failed(e.to_string()))?;
        write_finished(&record, &json)?;
    }
    let files: Vec<PathBuf> = (0..levels).map(level_file).collect();
    let levels: Vec<StoredImage> =
        files.iter().map(|file| stored_image(file)).collect::<Result<_, IngestError>>()?;
    // Encoders make other bytes on other processors: what is published under one name is the same.
    hasher = blake3::Hasher::new();
    hasher.update(original.as_bytes());
    for level in &levels {
        hasher.update(&level.bytes.to_le_bytes()).update(&level.crc32.to_le_bytes());
    }
    Ok(StagedCamera {
        rig_camera: RigCamera {
            id: camera.id.clone(),
            position_in_rig: camera.position_in_rig,
            cam_from_rig: camera.cam_from_rig,
            projection,
            levels,
            mask: mask.map(|mask| mask.mask.clone()),
            version: hasher.finalize().to_hex()[..VERSION_DIGITS].to_owned(),
        },
        files,
        recompressed: !photograph.is_jpeg(),
    })
}

fn is_finished(
    record: &Path,
    size: UVec2,
    levels: u32,
    level_file: &impl Fn(u32) -> std::path::PathBuf,
) -> bool {
    let finished: Option<Finished> =
        fs::read(record).ok().and_then(|json| serde_json::from_slice(&json).ok());
    finished.is_some_and(|f| f.size == size && f.levels == levels)
        && (0..levels).all(|level| level_file(level).is_file())
}

/// The projection of the image as it is, whatever size its lens was calibrated for.
fn projection(camera: &DraftCamera, size: UVec2) -> Result<Projection, IngestError> {
    match camera.lens {
        DraftLens::Calibrated(lens) if same_proportions(lens.size, size) => {
            Ok(Projection::Pinhole(if lens.size == size { lens } else { lens.scaled_to(size) }))
        }
        DraftLens::Calibrated(lens) => Err(BadInput::error(
            &camera.image,
            "",
            format!(
                "it is {} pixels, not of the proportions of camera {}, calibrated for {}",
                by(size),
                camera.id,
                by(lens.size)
            ),
            "give the image uncropped, or calibrate for its size",
        )),
        DraftLens::Sphere if size.x.abs_diff(2 * size.y) <= 1 => {
            Ok(Projection::Equirectangular { size })
        }
        DraftLens::Sphere => Err(BadInput::error(
            &camera.image,
            "",
            format!("it is {} pixels, not twice as wide as high", by(size)),
            "give the whole sphere, 360° by 180°, without borders",
        )),
    }
}

/// Whether one size scales to the other within a pixel of the smaller.
fn same_proportions(a: UVec2, b: UVec2) -> bool {
    let (a, b) = (a.as_dvec2(), b.as_dvec2());
    let (small, large) = if a.x <= b.x { (a, b) } else { (b, a) };
    (large.y * (small.x / large.x) - small.y).abs() <= 1.0
}

fn by(size: UVec2) -> String {
    format!("{}×{}", size.x, size.y)
}

#[cfg(test)]
mod tests;

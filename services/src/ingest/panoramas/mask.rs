//! Masks: which pixels of a camera show the scene, and not the vehicle.

use std::path::{Path, PathBuf};

use flaneur_scene::Mask;
use glam::UVec2;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::budget::{Budget, over_budget};
use super::draft::DraftMask;
use super::files::{stored_image, write_finished};
use super::photograph::Photograph;
use crate::ingest::street::MaskColour;
use crate::ingest::{BadInput, IngestError, Job};
use crate::layers::panoramas::mask_path;

/// A mask in the work folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct StagedMask {
    /// What the scene knows of it.
    pub(super) mask: Mask,
    pub(super) size: UVec2,
    pub(super) file: PathBuf,
}

/// Changes whenever the same mask image would give other bytes.
const VERSION: &str = "flaneur mask 1";

/// Writes the mask as an 8-bit grey PNG, 255 where the scene shows.
///
/// Masks are often JPEGs, whose black and white are not quite: what is lighter than middle
/// grey is white.
pub(super) fn stage(
    job: &Job,
    budget: &Budget,
    mask: &DraftMask,
) -> Result<StagedMask, IngestError> {
    let photograph = Photograph::inspect(&mask.image)?;
    let _share = budget
        .take(photograph.memory)
        .ok_or_else(|| over_budget(&mask.image, photograph.memory, budget))?;
    let bytes = photograph.read()?;
    let mut hasher = blake3::Hasher::new();
    hasher.update(VERSION.as_bytes()).update(&[u8::from(mask.exclude == MaskColour::White)]);
    hasher.update(&bytes);
    let version = &hasher.finalize().to_hex()[..8];
    let name = format!("{}.{version}", stem(&mask.image));
    let file = job.work.join(mask_path(&name));
    let size = photograph.size;
    if !file.is_file() {
        let rgb = photograph.decode(&bytes)?;
        let scene_is_white = mask.exclude == MaskColour::Black;
        let grey: Vec<u8> = rgb
            .as_chunks::<3>()
            .0
            .iter()
            .map(|pixel| if is_white(pixel) == scene_is_white { 255 } else { 0 })
            .collect();
        let mut png = Vec::new();
        PngEncoder::new(&mut png)
            .write_image(&grey, size.x, size.y, ExtendedColorType::L8)
            .map_err(|e| {
                BadInput::error(&mask.image, "", format!("cannot be stored: {e}"), "save it again")
            })?;
        write_finished(&file, &png)?;
    }
    let image = stored_image(&file)?;
    Ok(StagedMask { mask: Mask { name, image }, size, file })
}

/// Rec. 601 luma above the middle.
fn is_white(&[r, g, b]: &[u8; 3]) -> bool {
    299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b) >= 127_500
}

/// The file's name without extension, as far as it can be part of a store's path.
fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let kept = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
    let stem: String = stem.chars().map(kept).take(100).collect();
    if stem.is_empty() { "mask".into() } else { stem }
}

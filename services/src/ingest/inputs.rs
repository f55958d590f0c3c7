//! Which files each layer reads: what its fingerprint covers.

use std::io;
use std::path::{Path, PathBuf};

use super::street::{
    EquirectangularSpec, FootprintsSpec, GroundSpec, ItownsSpec, PanoramasSpec, glob,
};

/// Files in a COLMAP model that are read.
const COLMAP_MODEL: [&str; 4] = ["cameras.txt", "cameras.bin", "images.txt", "images.bin"];

/// How the names of photographs end.
const IMAGE_ENDINGS: [&str; 7] = ["jpg", "jpeg", "png", "webp", "tif", "tiff", "bmp"];

/// Largest calibration in which masks are looked for, bytes.
const MAX_CALIBRATION: u64 = 64 << 20;

/// The terrain's own file, where it has one.
pub(super) fn of_ground(spec: &GroundSpec) -> Vec<PathBuf> {
    match spec {
        GroundSpec::PointsJson { path } => vec![path.clone()],
        GroundSpec::Constant { .. } | GroundSpec::Points { .. } => Vec::new(),
    }
}

/// The files of outlines.
pub(super) fn of_footprints(specs: &[FootprintsSpec]) -> Vec<PathBuf> {
    specs.iter().map(|spec| spec.path.clone()).collect()
}

/// Poses, calibrations, masks and every photograph that they may name. Which of the
/// photographs are used is seen only when poses are read, so some may be listed needlessly;
/// none is missing.
pub(super) fn of_panoramas(specs: &[PanoramasSpec]) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for spec in specs {
        match spec {
            PanoramasSpec::Itowns(spec) => of_itowns(spec, &mut files)?,
            PanoramasSpec::Colmap(spec) => {
                let model = COLMAP_MODEL.iter().map(|name| spec.model.join(name));
                files.extend(model.filter(|path| path.is_file()));
                photographs(&spec.images, &mut files)?;
            }
            PanoramasSpec::Equirectangular(EquirectangularSpec { list, images, .. }) => {
                files.push(list.clone());
                photographs(images, &mut files)?;
            }
        }
    }
    files.sort();
    files.dedup();
    Ok(files)
}

fn of_itowns(spec: &ItownsSpec, files: &mut Vec<PathBuf>) -> io::Result<()> {
    files.push(spec.poses.clone());
    files.push(spec.calibration.clone());
    files.extend(masks(&spec.calibration));
    files.extend(glob::expand(spec.root.folder(), &spec.images.glob())?);
    Ok(())
}

/// The mask images that a calibration names and that exist. What is wrong with the
/// calibration is for its reader to say.
fn masks(calibration: &Path) -> Vec<PathBuf> {
    #[derive(serde::Deserialize)]
    struct Camera {
        mask: Option<String>,
    }
    let small = std::fs::metadata(calibration).is_ok_and(|meta| meta.len() <= MAX_CALIBRATION);
    let text = if small { std::fs::read(calibration).unwrap_or_default() } else { Vec::new() };
    let cameras: Vec<Camera> = serde_json::from_slice(&text).unwrap_or_default();
    let folder = calibration.parent().unwrap_or(Path::new("/"));
    let masks = cameras.into_iter().filter_map(|camera| camera.mask);
    masks.map(|mask| folder.join(mask)).filter(|path| path.is_file()).collect()
}

/// All images in a folder and below.
fn photographs(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    let all = glob::expand(folder, "**")?;
    files.extend(all.into_iter().filter(|path| {
        path.extension().and_then(|ending| ending.to_str()).is_some_and(|ending| {
            IMAGE_ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known))
        })
    }));
    Ok(())
}

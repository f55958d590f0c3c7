//! From finished layers to the objects of a scene and its manifest.

use std::path::Path;

use flaneur_scene::SceneInfo;
use glam::DVec3;

use super::build::Built;
use super::fingerprint::content_hash;
use super::plan::Plan;
use super::publish::StagedObject;
use super::street::Street;
use super::{BadInput, IngestError, Job};
use crate::store::{
    FileEntry, FootprintsLayer, GroundLayer, Manifest, PanoramasLayer, PointsLayer,
};

/// Hexadecimal digits of a content's hash in a path.
const VERSION: usize = 8;

/// A scene ready to be published.
pub(super) struct Assembled {
    /// Its objects, without the manifest.
    pub(super) objects: Vec<StagedObject>,
    /// Its manifest.
    pub(super) manifest: Manifest,
    /// Bytes of its objects.
    pub(super) bytes: u64,
}

/// Names every file of the layers by its content, and describes them.
pub(super) fn assemble(
    street: &Street,
    plan: &Plan,
    built: &Built,
    job: &Job,
) -> Result<Assembled, IngestError> {
    let bounds = built.bounds();
    if bounds.is_empty() {
        return Err(BadInput::error(
            &street.file,
            "",
            "nothing of the street could be used",
            "see the warnings above",
        ));
    }
    let mut objects = Vec::new();
    let mut entry = |name: &str, ending: &str, file: &Path| {
        let entry = file_entry(name, ending, file, job)?;
        objects.push((entry.path.clone(), file.to_owned()));
        Ok::<_, IngestError>(entry)
    };
    let mut points = Vec::new();
    for staged in &built.points {
        let source = staged.source.name.clone();
        let file = entry(&format!("points/{source}"), "copc.laz", &staged.file)?;
        let stations = staged.stations.as_deref();
        let stations =
            stations.map(|file| entry(&format!("points/{source}"), "stations.json", file));
        points.push(PointsLayer { source, file, stations: stations.transpose()? });
    }
    let mut ground = None;
    if let Some(staged) = &built.ground {
        ground = Some(GroundLayer { file: entry("ground", "tif", &staged.file)? });
    }
    let mut footprints = None;
    if let Some(staged) = &built.footprints {
        footprints = Some(FootprintsLayer { file: entry("footprints", "fgb", &staged.file)? });
    }
    let mut panoramas = None;
    if let Some(staged) = &built.panoramas {
        let delivered = staged.delivered.as_deref();
        let delivered = delivered.map(|file| entry("panoramas", "delivered.json", file));
        panoramas = Some(PanoramasLayer {
            delivered: delivered.transpose()?,
            file: entry("panoramas", "fgb", &staged.table)?,
        });
        objects.extend(staged.objects.iter().cloned());
    }
    objects.sort();
    objects.dedup();
    let mut bytes = 0;
    for (_, file) in &objects {
        bytes += std::fs::metadata(file).map_err(|e| IngestError::io("read", file, e))?.len();
    }
    let staged_panoramas = built.panoramas.as_ref();
    let scene = SceneInfo {
        name: street.scene.name.clone(),
        crs: street.scene.crs.clone(),
        geographic_origin: street.scene.geographic_origin,
        origin: DVec3::round(bounds.centre()),
        bounds,
        footprints: built.footprints.as_ref().map_or(0, |staged| staged.count),
        panoramas: staged_panoramas.map_or(0, |staged| staged.panoramas),
        images: staged_panoramas.map_or(0, |staged| staged.images),
        ground: built.ground.as_ref().map(|staged| staged.layout),
        point_sources: built.points.iter().map(|staged| staged.source.clone()).collect(),
        // Follows from all the rest, so it is made when the manifest is read.
        version: String::new(),
    };
    let manifest = Manifest {
        format: Manifest::FORMAT,
        scene,
        fingerprint: plan.fingerprint.clone(),
        footprints,
        ground,
        panoramas,
        points,
        warnings: built.warnings.lines(),
        generator: concat!("flaneur ", env!("CARGO_PKG_VERSION")).to_owned(),
    };
    Ok(Assembled { objects, manifest, bytes })
}

/// `{name}.{first digits of the content's hash}.{ending}`.
fn file_entry(name: &str, ending: &str, file: &Path, job: &Job) -> Result<FileEntry, IngestError> {
    let blake3 = content_hash(file, job)?;
    let bytes = std::fs::metadata(file).map_err(|e| IngestError::io("read", file, e))?.len();
    let version = blake3.get(..VERSION).unwrap_or(&blake3);
    Ok(FileEntry { path: format!("{name}.{version}.{ending}"), bytes, blake3 })
}

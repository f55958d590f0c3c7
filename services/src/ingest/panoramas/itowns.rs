//! Rigs as iTowns 2 publishes them: a JSON list of poses and a JSON calibration.

mod calibration;

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use serde::Deserialize;

use super::draft::{Draft, DraftCamera, DraftLens};
use super::files::read_whole;
use super::pose::{PoseFrame, PublishedPose, checked_name, checked_time};
use crate::crs::{Crs, CrsError};
use crate::ingest::street::ItownsSpec;
use crate::ingest::{BadInput, IngestError, Job};
use calibration::CalibratedCamera;

/// The panoramas of an entry, each with every camera of the calibration.
pub(super) fn read(job: &Job, spec: &ItownsSpec, crs: &Crs) -> Result<Vec<Draft>, IngestError> {
    read_with(job, spec, &|at| crs.meridian_convergence(at))
}

/// [`read`] with another meridian convergence.
pub(super) fn read_with(
    job: &Job,
    spec: &ItownsSpec,
    convergence: &dyn Fn(DVec2) -> Result<f64, CrsError>,
) -> Result<Vec<Draft>, IngestError> {
    let cameras = calibration::read(job, spec)?;
    let frame = PoseFrame {
        north: spec.heading,
        convergence,
        height_offset_m: spec.height_offset_m,
        boresight_deg: spec.boresight_deg,
    };
    let bytes = read_whole(job, &spec.poses)?;
    let published: Vec<PublishedPanorama> = serde_json::from_slice(&bytes).map_err(|e| {
        BadInput::json(
            &spec.poses,
            &e,
            "give a list of {\"id\", \"easting\", \"northing\", \"altitude\", \"heading\", \
             \"pitch\", \"roll\"}",
        )
    })?;
    let mut drafts = Vec::with_capacity(published.len());
    for panorama in published {
        job.check()?;
        drafts.push(draft(spec, &frame, &cameras, panorama)?);
    }
    refuse_unknown_cameras(spec, &cameras, &drafts)?;
    Ok(drafts)
}

/// A name that may be written as a number.
#[derive(Deserialize)]
#[serde(untagged)]
enum Name {
    Number(u64),
    Text(String),
}

impl From<Name> for String {
    fn from(name: Name) -> Self {
        match name {
            Name::Number(number) => number.to_string(),
            Name::Text(text) => text,
        }
    }
}

/// Metres and degrees; other fields are left alone.
#[derive(Deserialize)]
struct PublishedPanorama {
    id: Name,
    easting: f64,
    northing: f64,
    altitude: f64,
    heading: f64,
    pitch: f64,
    roll: f64,
    date: Option<String>,
}

fn draft(
    spec: &ItownsSpec,
    frame: &PoseFrame<'_>,
    cameras: &[CalibratedCamera],
    published: PublishedPanorama,
) -> Result<Draft, IngestError> {
    let id: String = published.id.into();
    let place = format!("panorama {id:?}");
    let id = checked_name(id, &spec.poses, &place)?;
    let pose = PublishedPose {
        position: DVec3::new(published.easting, published.northing, published.altitude),
        heading_deg: published.heading,
        pitch_deg: published.pitch,
        roll_deg: published.roll,
    };
    let (position, world_from_rig) = frame.resolve(&pose, &spec.poses, &place)?;
    let cameras = cameras
        .iter()
        .map(|camera| {
            let path = spec.images.fill(&id, &camera.id);
            let image = spec.root.resolve(spec.root.folder(), &path, &spec.poses, &place)?;
            Ok(DraftCamera {
                id: camera.id.clone(),
                position_in_rig: camera.position_in_rig,
                cam_from_rig: camera.cam_from_rig,
                lens: DraftLens::Calibrated(camera.lens),
                image,
                mask: camera.mask.clone(),
            })
        })
        .collect::<Result<_, IngestError>>()?;
    Ok(Draft {
        id,
        position,
        world_from_rig,
        time: checked_time(published.date),
        uncertainty_m: spec.uncertainty_m,
        cameras,
        file: spec.poses.clone(),
        place,
    })
}

/// A calibration that lacks a camera lacks it in every panorama: these many tell.
const PANORAMAS_SEARCHED: usize = 100;

/// An error where there are photographs of a camera that the calibration does not know.
fn refuse_unknown_cameras(
    spec: &ItownsSpec,
    cameras: &[CalibratedCamera],
    drafts: &[Draft],
) -> Result<(), IngestError> {
    const MARK: &str = "\u{1}";
    let known: BTreeSet<&str> = cameras.iter().map(|camera| camera.id.as_str()).collect();
    let mut folders: HashMap<PathBuf, BTreeSet<String>> = HashMap::new();
    for draft in drafts.iter().take(PANORAMAS_SEARCHED) {
        let marked = spec.images.fill(&draft.id, MARK);
        let path = Path::new(&marked);
        let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { continue };
        // Only where the camera is once in the file's name, and only there, can it be found.
        let name = name.to_string_lossy();
        let Some((before, after)) = name.split_once(MARK) else { continue };
        if after.contains(MARK) || folder.to_string_lossy().contains(MARK) {
            continue;
        }
        let folder = spec.root.folder().join(folder);
        let names = folders.entry(folder).or_insert_with_key(|folder| file_names(folder));
        let unknown = names
            .range(before.to_owned()..)
            .take_while(|name| name.starts_with(before))
            .filter_map(|name| Some((name, name.get(before.len()..)?.strip_suffix(after)?)))
            .find(|(_, camera)| !camera.is_empty() && !known.contains(camera));
        if let Some((file, camera)) = unknown {
            return Err(BadInput::error(
                &spec.calibration,
                format!("camera {camera:?}"),
                format!("it is missing, but there is an image of it, {file:?}"),
                "add the camera to the calibration, or move its images elsewhere",
            ));
        }
    }
    Ok(())
}

/// Names in a folder; none where it cannot be read, for its images are then absent anyway.
fn file_names(folder: &Path) -> BTreeSet<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return BTreeSet::new() };
    entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect()
}

#[cfg(test)]
mod tests;

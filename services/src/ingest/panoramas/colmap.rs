//! COLMAP models: `cameras` and `images`, text or binary, in the scene's world frame.
//!
//! Every image is a panorama of one camera. A rig whose cameras stand apart by more than
//! their depth maps can tell is better kept as photographs of their own.

mod binary;
mod camera;
mod text;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec3};

use super::draft::{Draft, DraftCamera, DraftLens};
use super::pose::checked_name;
use crate::ingest::street::ColmapSpec;
use crate::ingest::{BadInput, IngestError, Job};
use camera::ColmapCamera;

/// The images of the model, in its order, each a panorama named after its file:
/// `left/0001.jpg` becomes `left_0001`.
pub(super) fn read(job: &Job, spec: &ColmapSpec) -> Result<Vec<Draft>, IngestError> {
    let (cameras_file, cameras_binary) = model_file(&spec.model, "cameras")?;
    let (images_file, images_binary) = model_file(&spec.model, "images")?;
    let cameras = if cameras_binary {
        binary::cameras(&cameras_file)
    } else {
        text::cameras(job, &cameras_file)
    }?;
    let images = if images_binary {
        binary::images(job, &images_file)
    } else {
        text::images(job, &images_file)
    }?;
    let by_id: HashMap<u32, &ColmapCamera> = cameras.iter().map(|c| (c.id, c)).collect();
    let mut names: HashMap<String, String> = HashMap::new();
    let mut drafts = Vec::with_capacity(images.len());
    for image in images {
        job.check()?;
        let place = format!("{}, image {:?}", image.place, image.name);
        let camera = by_id.get(&image.camera_id).ok_or_else(|| {
            BadInput::error(
                &images_file,
                &place,
                format!("its camera {} is not in {}", image.camera_id, cameras_file.display()),
                "add the camera, or remove the image from the model",
            )
        })?;
        let id = checked_name(panorama_name(&image.name), &images_file, &place)?;
        if let Some(first) = names.insert(id.clone(), image.name.clone()) {
            return Err(BadInput::error(
                &images_file,
                &place,
                format!("it would be named {id:?}, as {first:?} is"),
                "rename one of the two",
            ));
        }
        drafts.push(draft(spec, &images_file, place, id, &image, camera)?);
    }
    Ok(drafts)
}

/// An image of the model: `p_cam = R(q) p_world + t`.
#[derive(Clone, Debug, PartialEq)]
struct ColmapImage {
    name: String,
    camera_id: u32,
    /// w, x, y, z.
    quaternion: [f64; 4],
    translation: [f64; 3],
    /// Where in the file: "line 5", "byte 120".
    place: String,
}

/// How far the norm of a quaternion may be from 1. COLMAP writes 17 digits; people who round
/// to three still pass.
const NORM_TOLERANCE: f64 = 1e-3;

/// Rig axes (right, forward, up) as camera axes (right, down, forward).
const CAM_FROM_RIG: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);

/// Farther from the origin than this no projected CRS reaches: metres.
const FARTHEST: f64 = 1e8;

fn draft(
    spec: &ColmapSpec,
    file: &Path,
    place: String,
    id: String,
    image: &ColmapImage,
    camera: &ColmapCamera,
) -> Result<Draft, IngestError> {
    let [w, x, y, z] = image.quaternion;
    let quaternion = DQuat::from_xyzw(x, y, z, w);
    let norm = quaternion.length();
    if !((norm - 1.0).abs() <= NORM_TOLERANCE) {
        return Err(BadInput::error(
            file,
            place,
            format!("its quaternion has norm {norm}, which is no rotation"),
            "give qw qx qy qz of norm 1",
        ));
    }
    let world_from_cam = DMat3::from_quat(quaternion.normalize()).transpose();
    let position = -(world_from_cam * DVec3::from(image.translation));
    // Written so that NaN is refused.
    if !(position.abs().max_element() <= FARTHEST) {
        return Err(BadInput::error(
            file,
            place,
            format!("its camera is at {position}"),
            "give the model in metres in the CRS of the street",
        ));
    }
    let path = spec.root.resolve(&spec.images, &image.name, file, &place)?;
    Ok(Draft {
        id,
        position,
        world_from_rig: world_from_cam * CAM_FROM_RIG,
        time: None,
        uncertainty_m: spec.uncertainty_m,
        cameras: vec![DraftCamera {
            id: camera.id.to_string(),
            position_in_rig: DVec3::ZERO,
            cam_from_rig: CAM_FROM_RIG,
            lens: DraftLens::Calibrated(camera.lens),
            image: path,
            mask: None,
        }],
        file: file.to_owned(),
        place,
    })
}

/// The file's name without its extension, folders joined by `_`.
fn panorama_name(image: &str) -> String {
    let image = image.trim_start_matches("./");
    let folders_and_name = image.replace(['/', '\\'], "_");
    let extension = Path::new(image).extension().map_or(0, |e| e.len() + 1);
    folders_and_name[..folders_and_name.len() - extension].to_owned()
}

/// The binary file where there is one, else the text file, as COLMAP itself chooses.
fn model_file(model: &Path, name: &str) -> Result<(PathBuf, bool), IngestError> {
    for (extension, binary) in [("bin", true), ("txt", false)] {
        let path = model.join(format!("{name}.{extension}"));
        if path.is_file() {
            return Ok((path, binary));
        }
    }
    Err(BadInput::error(
        model,
        "",
        format!("it holds neither {name}.bin nor {name}.txt"),
        "let model name the folder of a COLMAP model",
    ))
}

#[cfg(test)]
mod tests;

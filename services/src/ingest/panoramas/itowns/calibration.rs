//! The calibration of a rig: where its cameras sit, where they look, and their lenses.

use std::collections::HashSet;

use flaneur_scene::{Distortion, Intrinsics, Lens};
use glam::{DMat3, DVec2, DVec3, UVec2};
use serde::Deserialize;

use super::Name;
use crate::ingest::panoramas::draft::DraftMask;
use crate::ingest::panoramas::files::read_whole;
use crate::ingest::panoramas::pose::checked_name;
use crate::ingest::panoramas::rotation;
use crate::ingest::street::ItownsSpec;
use crate::ingest::{BadInput, IngestError, Job};

/// One camera of the rig.
#[derive(Clone, Debug)]
pub(super) struct CalibratedCamera {
    pub(super) id: String,
    pub(super) position_in_rig: DVec3,
    pub(super) cam_from_rig: DMat3,
    pub(super) lens: Lens,
    pub(super) mask: Option<DraftMask>,
}

/// The cameras of the calibration, in its order; at least one.
pub(super) fn read(job: &Job, spec: &ItownsSpec) -> Result<Vec<CalibratedCamera>, IngestError> {
    let file = &spec.calibration;
    let bytes = read_whole(job, file)?;
    let published: Vec<serde_json::Value> = serde_json::from_slice(&bytes)
        .map_err(|e| BadInput::json(file, &e, "give a JSON list of cameras"))?;
    let mut cameras = Vec::with_capacity(published.len());
    let mut ids = HashSet::new();
    for (i, value) in published.into_iter().enumerate() {
        let place = format!("camera {}", value.get("id").unwrap_or(&(i + 1).into()));
        let published = PublishedCamera::deserialize(value).map_err(|e| {
            BadInput::error(
                file,
                &place,
                e.to_string(),
                "give it \"id\", \"rotation\" (9 numbers), \"position\" (3), \"projection\" (9) \
                 and \"size\" (2)",
            )
        })?;
        let camera = calibrated(spec, published, &place)?;
        if !ids.insert(camera.id.clone()) {
            return Err(BadInput::error(file, place, "it is listed twice", "keep one of the two"));
        }
        cameras.push(camera);
    }
    if cameras.is_empty() {
        return Err(BadInput::error(file, "", "it lists no camera", "list the rig's cameras"));
    }
    Ok(cameras)
}

#[derive(Deserialize)]
struct PublishedCamera {
    id: Name,
    /// Path of the mask image, from the calibration's folder.
    mask: Option<String>,
    /// Rows of `R_cam_from_rig`.
    rotation: [f64; 9],
    /// Metres in the rig frame.
    position: [f64; 3],
    /// Rows of the pinhole matrix, pixels.
    projection: [f64; 9],
    /// Width and height to which the pixels refer.
    size: [u32; 2],
    distortion: Option<PublishedDistortion>,
}

#[derive(Deserialize)]
struct PublishedDistortion {
    /// Principal point of symmetry, pixels.
    pps: [f64; 2],
    /// Coefficients of r³, r⁵ and r⁷.
    poly357: [f64; 3],
    /// Radius in pixels within which the polynomial was fitted.
    limit: Option<f64>,
}

/// Radius in pixels for calibrations that state none; the polynomial's own turning point
/// limits it further. JSON has no infinity.
const NO_LIMIT_PX: f64 = 1e9;

fn calibrated(
    spec: &ItownsSpec,
    published: PublishedCamera,
    place: &str,
) -> Result<CalibratedCamera, IngestError> {
    let file = &spec.calibration;
    let refuse = |problem: String, remedy: &str| BadInput::error(file, place, problem, remedy);
    let id = checked_name(published.id.into(), file, place)?;
    let rows = DMat3::from_cols_array(&published.rotation).transpose();
    let cam_from_rig = rotation::nearest(rows).map_err(|deviation| {
        refuse(
            format!(
                "its rotation is not orthonormal: it deviates by {deviation:.3e}, more than {:.0e}",
                rotation::TOLERANCE
            ),
            "give the nine entries of a rotation matrix row by row, with at least four digits",
        )
    })?;
    let [fx, skew, cx, zero, fy, cy, bottom @ ..] = published.projection;
    if skew != 0.0 || zero != 0.0 || bottom != [0.0, 0.0, 1.0] {
        return Err(refuse(
            format!("its projection is {:?}", published.projection),
            "give fx 0 cx 0 fy cy 0 0 1; a skew is not supported",
        ));
    }
    if !(fx > 0.0 && fy > 0.0) {
        return Err(refuse(format!("its focal lengths are {fx} and {fy}"), "give positive pixels"));
    }
    let size = UVec2::from(published.size);
    if size.min_element() == 0 {
        return Err(refuse(format!("its size is {size}"), "give the calibrated image's size"));
    }
    let distortion = match published.distortion {
        None => Distortion::None,
        Some(published) => {
            let limit_px = published.limit.unwrap_or(NO_LIMIT_PX);
            if !(limit_px > 0.0) {
                return Err(refuse(format!("its distortion limit is {limit_px}"), "give pixels"));
            }
            Distortion::RadialPixels {
                centre: DVec2::from(published.pps),
                k: published.poly357,
                limit_px,
            }
        }
    };
    let mask = match (spec.masks_exclude, published.mask) {
        (Some(exclude), Some(path)) => {
            let folder = file.parent().unwrap_or_else(|| spec.root.folder());
            let image = spec.root.resolve(folder, &path, file, place)?;
            Some(DraftMask { image, exclude })
        }
        _ => None,
    };
    Ok(CalibratedCamera {
        id,
        position_in_rig: DVec3::from(published.position),
        cam_from_rig,
        lens: Lens { size, intrinsics: Intrinsics { fx, fy, cx, cy }, distortion },
        mask,
    })
}

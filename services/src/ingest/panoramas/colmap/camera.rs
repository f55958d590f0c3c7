//! COLMAP's camera models as lenses.

use std::path::Path;

use flaneur_scene::{Distortion, Intrinsics, Lens};
use glam::UVec2;

use crate::ingest::{BadInput, IngestError};

/// A camera of the model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ColmapCamera {
    pub(super) id: u32,
    pub(super) lens: Lens,
}

/// The models that are read: COLMAP's number and name, and how many parameters they take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Model {
    SimplePinhole,
    Pinhole,
    SimpleRadial,
    Radial,
    OpenCv,
    OpenCvFisheye,
}

const MODELS: [(u32, &str, usize, Model); 6] = [
    (0, "SIMPLE_PINHOLE", 3, Model::SimplePinhole),
    (1, "PINHOLE", 4, Model::Pinhole),
    (2, "SIMPLE_RADIAL", 4, Model::SimpleRadial),
    (3, "RADIAL", 5, Model::Radial),
    (4, "OPENCV", 8, Model::OpenCv),
    (5, "OPENCV_FISHEYE", 8, Model::OpenCvFisheye),
];

impl Model {
    /// The model with COLMAP's number.
    pub(super) fn by_number(number: u32, file: &Path, place: &str) -> Result<Self, IngestError> {
        let found = MODELS.iter().find(|m| m.0 == number).map(|m| m.3);
        found.ok_or_else(|| unsupported(file, place, &format!("number {number}")))
    }

    /// The model with COLMAP's name.
    pub(super) fn by_name(name: &str, file: &Path, place: &str) -> Result<Self, IngestError> {
        let found = MODELS.iter().find(|m| m.1 == name).map(|m| m.3);
        found.ok_or_else(|| unsupported(file, place, &format!("{name:?}")))
    }

    /// Number of parameters.
    pub(super) fn parameters(self) -> usize {
        MODELS.iter().find(|m| m.3 == self).map_or(0, |m| m.2)
    }
}

fn unsupported(file: &Path, place: &str, model: &str) -> IngestError {
    let names: Vec<&str> = MODELS.iter().map(|m| m.1).collect();
    BadInput::error(
        file,
        place,
        format!("its model {model} is not supported"),
        format!("undistort the images with COLMAP, or calibrate as one of {}", names.join(", ")),
    )
}

/// The lens of a camera, its parameters checked.
pub(super) fn lens(
    model: Model,
    size: [u64; 2],
    parameters: &[f64],
    file: &Path,
    place: &str,
) -> Result<Lens, IngestError> {
    let refuse = |problem: String, remedy: &str| BadInput::error(file, place, problem, remedy);
    let brown = |k: [f64; 3], p: [f64; 2]| Distortion::Brown { k, p };
    let (fx, fy, cx, cy, distortion) = match (model, parameters) {
        (Model::SimplePinhole, &[f, cx, cy]) => (f, f, cx, cy, Distortion::None),
        (Model::Pinhole, &[fx, fy, cx, cy]) => (fx, fy, cx, cy, Distortion::None),
        (Model::SimpleRadial, &[f, cx, cy, k]) => (f, f, cx, cy, brown([k, 0.0, 0.0], [0.0; 2])),
        (Model::Radial, &[f, cx, cy, k1, k2]) => (f, f, cx, cy, brown([k1, k2, 0.0], [0.0; 2])),
        (Model::OpenCv, &[fx, fy, cx, cy, k1, k2, p1, p2]) => {
            (fx, fy, cx, cy, brown([k1, k2, 0.0], [p1, p2]))
        }
        (Model::OpenCvFisheye, &[fx, fy, cx, cy, k1, k2, k3, k4]) => {
            (fx, fy, cx, cy, Distortion::Fisheye { k: [k1, k2, k3, k4] })
        }
        _ => {
            return Err(refuse(
                format!("it has {} parameters, not {}", parameters.len(), model.parameters()),
                "give the parameters of its model",
            ));
        }
    };
    if let Some(value) = parameters.iter().find(|value| !value.is_finite()) {
        return Err(refuse(format!("a parameter is {value}"), "give finite numbers"));
    }
    if !(fx > 0.0 && fy > 0.0) {
        return Err(refuse(format!("its focal lengths are {fx} and {fy}"), "give positive pixels"));
    }
    let [Ok(width), Ok(height)] = size.map(u32::try_from) else {
        return Err(refuse(format!("its size is {size:?}"), "give the image's size in pixels"));
    };
    if width == 0 || height == 0 {
        return Err(refuse(format!("its size is {size:?}"), "give the image's size in pixels"));
    }
    Ok(Lens {
        size: UVec2::new(width, height),
        intrinsics: Intrinsics { fx, fy, cx, cy },
        distortion,
    })
}

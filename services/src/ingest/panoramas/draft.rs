//! Panoramas as a survey publishes them, before their images are looked at.

use std::path::PathBuf;

use flaneur_scene::Lens;
use glam::{DMat3, DVec3};

use crate::ingest::street::MaskColour;

/// A panorama whose images may or may not exist.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    /// Name, fit for a path segment.
    pub(super) id: String,
    /// Position of the rig's origin, world frame.
    pub(super) position: DVec3,
    /// Rotation of the rig, grid north.
    pub(super) world_from_rig: DMat3,
    /// RFC 3339, where known.
    pub(super) time: Option<String>,
    /// Standard deviation of the position, metres.
    pub(super) uncertainty_m: f64,
    /// Its cameras.
    pub(super) cameras: Vec<DraftCamera>,
    /// The file that lists it.
    pub(super) file: PathBuf,
    /// Where in that file.
    pub(super) place: String,
}

/// A camera of a draft.
#[derive(Clone, Debug)]
pub(super) struct DraftCamera {
    /// Name, fit for a path segment.
    pub(super) id: String,
    pub(super) position_in_rig: DVec3,
    pub(super) cam_from_rig: DMat3,
    pub(super) lens: DraftLens,
    /// Where the photograph ought to be.
    pub(super) image: PathBuf,
    pub(super) mask: Option<DraftMask>,
}

/// What the survey says about a lens.
#[derive(Clone, Copy, Debug)]
pub(super) enum DraftLens {
    /// For images of the lens's own size or of the same proportions.
    Calibrated(Lens),
    /// A full sphere, twice as wide as high.
    Sphere,
}

/// A mask image and what it marks.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct DraftMask {
    pub(super) image: PathBuf,
    /// The colour of what is not scene.
    pub(super) exclude: MaskColour,
}

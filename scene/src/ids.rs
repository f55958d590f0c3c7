//! Names of things that more than one crate speaks of.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// One photograph: the camera of a panorama, written `panorama/camera`.
///
/// Both parts are non-empty, at most 128 bytes, free of `/`, control
/// characters and leading dots, so that they can be path segments of a store.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ImageId {
    panorama: Arc<str>,
    camera: Arc<str>,
}

/// Why a text is no identifier.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum IdError {
    /// The text has no `/` between panorama and camera.
    #[error("{0:?} is not PANORAMA/CAMERA")]
    NoSlash(String),
    /// A part cannot be a path segment.
    #[error(
        "{0:?} cannot be part of an identifier: 1 to 128 bytes, no '/', no control characters, no leading '.'"
    )]
    BadPart(String),
}

impl ImageId {
    /// The photograph of `camera` in `panorama`, after checking both names.
    pub fn new(panorama: &str, camera: &str) -> Result<Self, IdError> {
        Self::check_part(panorama)?;
        Self::check_part(camera)?;
        Ok(Self { panorama: panorama.into(), camera: camera.into() })
    }

    /// The panorama's name: photographs that share it form one rig.
    pub fn panorama(&self) -> &str {
        &self.panorama
    }

    /// The camera's name within its rig.
    pub fn camera(&self) -> &str {
        &self.camera
    }

    /// Whether `part` may name a panorama or a camera.
    pub fn check_part(part: &str) -> Result<(), IdError> {
        let bad = part.is_empty()
            || part.len() > 128
            || part.starts_with('.')
            || part.chars().any(|c| c == '/' || c == '\\' || c.is_control());
        if bad { Err(IdError::BadPart(part.to_owned())) } else { Ok(()) }
    }
}

impl fmt::Display for ImageId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.panorama, self.camera)
    }
}

impl FromStr for ImageId {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        let (panorama, camera) =
            text.split_once('/').ok_or_else(|| IdError::NoSlash(text.to_owned()))?;
        Self::new(panorama, camera)
    }
}

impl TryFrom<String> for ImageId {
    type Error = IdError;

    fn try_from(text: String) -> Result<Self, IdError> {
        text.parse()
    }
}

impl From<ImageId> for String {
    fn from(id: ImageId) -> Self {
        id.to_string()
    }
}

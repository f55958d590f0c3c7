//! `scene.json`: what a scene consists of. It is written last, so a scene exists exactly
//! when its manifest does.

use flaneur_scene::SceneInfo;
use serde::{Deserialize, Serialize};

/// The manifest of a scene. Paths are relative to the scene's prefix.
///
/// Every file name holds a version made from its content or its inputs, so publishing a new
/// manifest never alters an object that readers of the old one still use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of this format: [`Manifest::FORMAT`].
    pub format: u32,
    /// What the scene holds.
    pub scene: SceneInfo,
    /// Fingerprint of every input and setting that the scene was made from: an ingest that
    /// would produce the same fingerprint has nothing to do.
    pub fingerprint: String,
    /// Footprints, where there are any.
    pub footprints: Option<FootprintsLayer>,
    /// Terrain, where there is any.
    pub ground: Option<GroundLayer>,
    /// Panoramas, where there are any.
    pub panoramas: Option<PanoramasLayer>,
    /// Point files, in the order of [`SceneInfo::point_sources`].
    pub points: Vec<PointsLayer>,
    /// What ingest could not use, one line each (absent images, skipped polygons, …).
    pub warnings: Vec<String>,
    /// Program and version that wrote the scene.
    pub generator: String,
}

/// An object of the scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Path relative to the scene's prefix.
    pub path: String,
    /// Size in bytes.
    pub bytes: u64,
    /// BLAKE3 of the content, hexadecimal.
    pub blake3: String,
}

/// `footprints.{version}.fgb`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FootprintsLayer {
    /// The FlatGeobuf.
    pub file: FileEntry,
}

/// `ground.{version}.tif`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GroundLayer {
    /// The GeoTIFF of heights.
    pub file: FileEntry,
}

/// `panoramas.{version}.fgb` with the poses, and the photographs below `panoramas/`:
/// `panoramas/{panorama}/{camera}/{image version}/{level}.jpg`, masks as `masks/{mask}.png`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PanoramasLayer {
    /// The FlatGeobuf of rigs, cameras and poses.
    pub file: FileEntry,
}

/// `points/{source}.{version}.copc.laz`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointsLayer {
    /// Name of the point source.
    pub source: String,
    /// The COPC file.
    pub file: FileEntry,
}

impl Manifest {
    /// The version of the manifest's format that this program writes and reads.
    pub const FORMAT: u32 = 1;

    /// Name of the manifest below the scene's prefix.
    pub const PATH: &'static str = "scene.json";
}

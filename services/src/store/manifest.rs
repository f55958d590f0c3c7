//! `scene.json`: what a scene consists of. It is written last, so a scene exists exactly
//! when its manifest does.

use flaneur_proto::{FieldError, v1};
use flaneur_scene::SceneInfo;
use serde::{Deserialize, Serialize};

use super::StoreError;

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

/// `panoramas.{version}.fgb` with the poses, `panoramas.{version}.delivered.json` with those that were
/// corrected, and the photographs below `panoramas/`:
/// `panoramas/{panorama}/{camera}/{image version}/{level}.jpg`, masks as `masks/{mask}.png`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PanoramasLayer {
    /// The FlatGeobuf of rigs, cameras and poses.
    pub file: FileEntry,
    /// The poses as they were delivered, where those are corrected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delivered: Option<FileEntry>,
}

/// `points/{source}.{version}.copc.laz`, and `points/{source}.{version}.stations.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointsLayer {
    /// Name of the point source.
    pub source: String,
    /// The COPC file.
    pub file: FileEntry,
    /// Where it was taken from, where its points have times.
    pub stations: Option<FileEntry>,
}

impl Manifest {
    /// The version of the manifest's format that this program writes and reads.
    pub const FORMAT: u32 = 3;

    /// Name of the manifest below the scene's prefix.
    pub const PATH: &'static str = "scene.json";

    /// The manifest of the scene that is called `scene` in its store, checked: what it says of
    /// the scene can be sent as it is, and every point source has its file.
    ///
    /// The name in the file gives way to `scene`, so a scene may be copied or renamed.
    pub fn parse(scene: &str, bytes: &[u8]) -> Result<Self, StoreError> {
        let bad = |problem: String| StoreError::BadManifest { scene: scene.to_owned(), problem };
        let format: Format = serde_json::from_slice(bytes).map_err(|e| bad(e.to_string()))?;
        if format.format != Self::FORMAT {
            return Err(bad(format!(
                "it has format {}, this program reads {}; ingest the survey again",
                format.format,
                Self::FORMAT
            )));
        }
        let mut manifest: Self = serde_json::from_slice(bytes).map_err(|e| bad(e.to_string()))?;
        scene.clone_into(&mut manifest.scene.name);
        manifest.scene.version = manifest.version();
        let info = v1::Scene::from(manifest.scene.clone());
        SceneInfo::try_from(info).map_err(|e: FieldError| bad(e.to_string()))?;
        let sources = manifest.scene.point_sources.iter().map(|source| &source.name);
        if !sources.eq(manifest.points.iter().map(|layer| &layer.source)) {
            return Err(bad("its point sources and point files differ".to_owned()));
        }
        let mut names: Vec<_> = manifest.points.iter().map(|layer| &layer.source).collect();
        names.sort();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(bad(format!("two point sources are named {:?}", pair[0])));
        }
        Ok(manifest)
    }

    /// A name for what the scene consists of: every object is either named here with its
    /// content's hash, or listed with its checksum in one that is.
    fn version(&self) -> String {
        let scene = SceneInfo { name: String::new(), version: String::new(), ..self.scene.clone() };
        let content = (&scene, &self.footprints, &self.ground, &self.panoramas, &self.points);
        let mut hasher = blake3::Hasher::new();
        // Written to a hasher, nothing of this can fail.
        let _ = serde_json::to_writer(&mut hasher, &content);
        hasher.finalize().to_hex()[..VERSION_DIGITS].to_owned()
    }
}

/// Hexadecimal digits of a scene's version.
const VERSION_DIGITS: usize = 32;

/// What every version of the manifest begins with.
#[derive(Deserialize)]
struct Format {
    format: u32,
}

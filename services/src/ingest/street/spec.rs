//! The contents of a `street.toml`, checked and with its paths resolved.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{ImagePattern, Root};

/// A survey: everything that one scene is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Street {
    /// The `street.toml`.
    pub file: PathBuf,
    /// Its folder.
    pub root: Root,
    /// `[scene]`.
    pub scene: SceneSpec,
    /// `[ground]`.
    pub ground: Option<GroundSpec>,
    /// `[[footprints]]`.
    pub footprints: Vec<FootprintsSpec>,
    /// `[[panoramas]]`.
    pub panoramas: Vec<PanoramasSpec>,
    /// `[[points]]`.
    pub points: Vec<PointsSpec>,
}

/// `[scene]`: name and frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneSpec {
    /// Name, fit to be a prefix in a store: ASCII letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// `EPSG:code`, or `local`.
    pub crs: String,
    /// Latitude, longitude (degrees) and height (metres) of (0, 0, 0) of a local CRS.
    pub geographic_origin: Option<[f64; 3]>,
}

/// `[ground]`: where terrain heights come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum GroundSpec {
    /// `format = "constant"`: one height everywhere.
    Constant {
        /// Height in metres, world frame.
        height_m: f64,
    },
    /// `format = "points-json"`: a list `[{"e":…,"n":…,"h":…}, …]`.
    PointsJson {
        /// The list.
        path: PathBuf,
    },
    /// `format = "points"`: from the scene's own point files.
    Points {
        /// LAS classes that are ground; the lowest points where absent.
        classes: Option<Vec<u8>>,
    },
}

/// `[[footprints]]`: one file of building outlines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FootprintsSpec {
    /// The file.
    pub path: PathBuf,
    /// Its format; found from its name and contents where absent.
    pub format: Option<FootprintsFormat>,
    /// Where heights come from. Absent: the geometry's own, which only CityJSON has.
    pub height: Option<HeightSource>,
    /// How far a wall may be from where the footprint puts it, metres, 0 where unknown.
    pub uncertainty_m: f64,
}

/// A format of footprints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FootprintsFormat {
    /// `"geojson"`.
    GeoJson,
    /// `"flatgeobuf"`.
    FlatGeobuf,
    /// `"cityjson"`, LoD1 or LoD2.
    CityJson,
}

/// Where the height of a building comes from, metres above the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum HeightSource {
    /// `height_property = "…"`: an attribute.
    Property(String),
    /// `height = "points"`: the points inside the outline.
    Points,
    /// `height = 12.0`: the same for all.
    Constant(f64),
}

/// `[[panoramas]]`: one set of posed photographs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PanoramasSpec {
    /// `format = "itowns"`.
    Itowns(ItownsSpec),
    /// `format = "colmap"`.
    Colmap(ColmapSpec),
    /// `format = "equirectangular"`.
    Equirectangular(EquirectangularSpec),
}

/// Panoramas of a rig: a list of poses and a calibration, both JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ItownsSpec {
    /// Where paths found in the data may lead.
    pub root: Root,
    /// The poses.
    pub poses: PathBuf,
    /// The calibration. Paths of masks in it start at its own folder.
    pub calibration: PathBuf,
    /// Path of a photograph, relative to the root's folder.
    pub images: ImagePattern,
    /// What the calibration's mask images mark as not scene; they are not used where absent.
    pub masks_exclude: Option<MaskColour>,
    /// What headings are measured from.
    pub heading: North,
    /// Added to the published altitudes, metres.
    pub height_offset_m: f64,
    /// Angles (degrees) about the rig's axes x (right), y (forward), z (up):
    /// `R_world_from_rig = Rz(−heading) Rx(pitch) Ry(roll) · Rx(b₀) Ry(b₁) Rz(b₂)`.
    pub boresight_deg: [f64; 3],
    /// How far a position may be off, metres, 0 where unknown.
    pub uncertainty_m: f64,
    /// Whether poses are corrected where the photographs clearly disagree with them.
    pub refine_poses: bool,
}

/// A COLMAP model, text or binary, in the scene's world frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColmapSpec {
    /// Where paths found in the data may lead.
    pub root: Root,
    /// Folder with `cameras` and `images`, each `.txt` or `.bin`.
    pub model: PathBuf,
    /// Folder at which the model's image names start.
    pub images: PathBuf,
    /// How far a position may be off, metres, 0 where unknown.
    pub uncertainty_m: f64,
    /// Whether poses are corrected where the photographs clearly disagree with them.
    pub refine_poses: bool,
}

/// Equirectangular panoramas listed with their poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EquirectangularSpec {
    /// Where paths found in the data may lead.
    pub root: Root,
    /// The list, CSV or GeoJSON (by its name: `.csv`, else GeoJSON).
    pub list: PathBuf,
    /// Folder at which the list's image paths start; by default the list's own.
    pub images: PathBuf,
    /// What headings are measured from.
    pub heading: North,
    /// Added to the listed heights, metres.
    pub height_offset_m: f64,
    /// As [`ItownsSpec::boresight_deg`].
    pub boresight_deg: [f64; 3],
    /// How far a position may be off, metres, 0 where unknown.
    pub uncertainty_m: f64,
}

/// A colour of a mask image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MaskColour {
    /// `"white"`.
    White,
    /// `"black"`.
    Black,
}

/// What headings are measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum North {
    /// `"true-north"`: turned by the meridian convergence of the CRS.
    True,
    /// `"grid-north"`: the y axis of the world frame. The default.
    Grid,
}

/// `[[points]]`: LAS, LAZ or COPC files that become one point source.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointsSpec {
    /// Name of the point source, unique in the street.
    pub name: String,
    /// The files, sorted; never empty.
    pub files: Vec<PathBuf>,
}

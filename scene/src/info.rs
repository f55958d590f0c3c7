//! What a scene holds, known before anything of it is fetched.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Bounds3, GroundLayout, OctreeCube};

/// A scene at a glance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneInfo {
    /// Name: the scene's prefix in its store.
    pub name: String,
    /// `EPSG:code`, or `local` for metres without a known projection.
    pub crs: String,
    /// Latitude, longitude (degrees) and height (metres) of (0, 0, 0) of a local CRS.
    pub geographic_origin: Option<[f64; 3]>,
    /// The scene's own origin near its centre, world frame.
    pub origin: DVec3,
    /// Box around everything in it.
    pub bounds: Bounds3,
    /// Number of footprints.
    pub footprints: u64,
    /// Number of panoramas.
    pub panoramas: u64,
    /// Number of photographs (cameras of panoramas).
    pub images: u64,
    /// The terrain's tiles, where there is terrain.
    pub ground: Option<GroundLayout>,
    /// Its point sources.
    pub point_sources: Vec<PointSource>,
    /// Changes with anything that the scene consists of, its name apart.
    pub version: String,
}

/// One octree of points, with what it takes to decode a node's LAZ bytes alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointSource {
    /// Name, unique in the scene.
    pub name: String,
    /// Points in all nodes.
    pub point_count: u64,
    /// Tight box around the points.
    pub bounds: Bounds3,
    /// The octree's cube.
    pub cube: OctreeCube,
    /// LAS point data record format: 6, 7 or 8.
    pub point_format: u8,
    /// Bytes of an uncompressed record, extra bytes included.
    pub record_length: u16,
    /// LAS scale factors.
    pub scale: DVec3,
    /// LAS offsets.
    pub offset: DVec3,
    /// Payload of the LASzip VLR.
    pub laszip_vlr: Vec<u8>,
    /// Payload of the extra-bytes VLR, empty where there is none.
    pub extra_bytes_vlr: Vec<u8>,
    /// What the points' GPS times count from, as the survey declares it.
    #[serde(default)]
    pub gps_time: GpsTimeKind,
}

/// What GPS times count from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GpsTimeKind {
    /// It was not kept: the scene was made by an older program.
    #[default]
    Unknown,
    /// From the beginning of a GPS week, Sunday 0:00 of GPS time; nobody says of which.
    Week,
    /// Adjusted standard GPS time: seconds since the GPS epoch, less 10^9.
    Adjusted,
}

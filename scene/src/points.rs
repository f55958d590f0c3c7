//! Decoded points of one octree node.

use glam::DVec3;

use crate::{NodeKey, PointStations};

/// Identity of a node among all point sources of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PointNodeId {
    /// Index of the source in [`crate::SceneInfo::point_sources`].
    pub source: u16,
    /// Address in that source's octree.
    pub key: NodeKey,
}

/// The points of one node, as columns of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct PointChunk {
    /// Identity.
    pub id: PointNodeId,
    /// World position of the local origin.
    pub origin: DVec3,
    /// Positions relative to the origin, metres.
    pub positions: Vec<[f32; 3]>,
    /// Colours, sRGB; empty where the survey has none, black where a point has none.
    pub colours: Vec<[u8; 3]>,
    /// Return intensities; empty where the survey has none.
    pub intensities: Vec<u16>,
    /// LAS classes.
    pub classes: Vec<u8>,
    /// Unit normals of the surface, of either sign; zero where a point's neighbours are no
    /// surface. Empty where none were asked for.
    pub normals: Vec<[f32; 3]>,
    /// Where they were taken from.
    pub stations: PointStations,
    /// Typical distance between the points of this level, metres: sets the splat size.
    pub spacing_m: f32,
    /// The same around each point; empty where it is not known.
    pub spacings_m: Vec<f32>,
}

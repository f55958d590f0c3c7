//! What every other crate of Flaneur shares: frames, cameras, meshes, points,
//! and the updates that carry them to a renderer.
//!
//! # Frames and units
//!
//! - **World**: a projected CRS in metres, x east, y north, z up, `f64`.
//! - **Rig**: x right, y forward, z up, origin at the rig's reference point.
//! - **Camera**: x right, y down, z forward; `p_cam = R_cam_from_world (P − C)`.
//! - **Pixels**: origin at the top-left *corner*; the centre of the first pixel
//!   is (0.5, 0.5).
//! - Angles are radians unless a name ends in `_deg`. Headings are clockwise
//!   from grid north. Transforms are named `b_from_a`.
//!
//! This crate knows none of the others, no file format, no network and no GPU.

mod bounds;
mod camera;
mod cube;
mod distortion;
mod extrude;
mod footprint;
mod ground;
mod ids;
mod info;
mod mesh;
mod octree;
mod orientation;
mod panorama;
mod points;
mod srgb;
mod stations;
mod update;
mod view;

pub use bounds::{Bounds2, Bounds3, Region};
pub use camera::{Intrinsics, Lens, PosedCamera};
pub use cube::{CUBE_FACES, CubeFace};
pub use distortion::Distortion;
pub use extrude::{extrude_footprints, triangulate_ground};
pub use footprint::{Footprint, Polygon};
pub use ground::{GroundLayout, GroundTile};
pub use ids::{IdError, ImageId};
pub use info::{GpsTimeKind, PointSource, SceneInfo};
pub use mesh::{MeshTile, MeshVertex, SurfaceClass, TileKey, TileLayer};
pub use octree::{Node, NodeKey, OctreeCube};
pub use orientation::{heading_pitch_roll, world_from_rig};
pub use panorama::{Mask, Panorama, Projection, RigCamera, StoredImage};
pub use points::{PointChunk, PointNodeId};
pub use srgb::{linear_from_srgb, srgb_from_linear};
pub use stations::{PointStations, Station, StationCorrection};
pub use update::{ImageUpdate, SceneUpdate};
pub use view::{Ray, View, ViewProjection};

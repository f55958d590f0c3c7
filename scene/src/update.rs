//! The only language in which a renderer is told what is there.

use std::sync::Arc;

use glam::UVec2;

use crate::{ImageId, MeshTile, PointChunk, PointNodeId, PosedCamera, TileKey};

/// A change of what a renderer holds. Payloads are shared, never copied.
#[derive(Clone, Debug)]
pub enum SceneUpdate {
    /// Adds a tile of mesh, or replaces the one with the same key.
    Mesh(Arc<MeshTile>),
    /// Removes a tile of mesh.
    DropMesh(TileKey),
    /// Adds a photograph, or replaces its pixels by those of another level.
    Image(Arc<ImageUpdate>),
    /// Removes a photograph.
    DropImage(ImageId),
    /// Adds the points of a node. Nodes are additive.
    Points(Arc<PointChunk>),
    /// Removes the points of a node.
    DropPoints(PointNodeId),
}

/// A photograph at one level of its pyramid.
#[derive(Clone, Debug)]
pub struct ImageUpdate {
    /// Which photograph. Those of one panorama form a rig.
    pub id: ImageId,
    /// Level of the pyramid, 0 the finest.
    pub level: u32,
    /// Where it was taken. The lens is that of level 0; see [`crate::Lens::scaled_to`].
    pub camera: PosedCamera,
    /// Size of `rgba` in pixels.
    pub size: UVec2,
    /// sRGB with straight alpha, rows from the top. Alpha is 0 where the mask says that the
    /// pixel does not show the scene, and elsewhere how far inside the mask the pixel lies: a
    /// photograph's say rises with it, from next to none at 1 to all at 255. Without a mask, and
    /// away from its edges, it is 255.
    pub rgba: Vec<u8>,
    /// How far the camera's position may be off, metres.
    pub uncertainty_m: f64,
}

//! What the receiver of the updates holds.

use std::collections::{BTreeMap, BTreeSet};

use flaneur_scene::{ImageId, PointNodeId, SceneUpdate, TileKey};

/// The outcome of all updates that were handed over.
#[derive(Clone, Debug, Default)]
pub(crate) struct Resident {
    /// Tiles of mesh.
    pub(crate) tiles: BTreeSet<TileKey>,
    /// Photographs with their levels.
    pub(crate) images: BTreeMap<ImageId, u32>,
    /// Point nodes, and whether their points have normals; none where no point is left.
    pub(crate) nodes: BTreeMap<PointNodeId, Option<bool>>,
}

impl Resident {
    /// Takes note of an update that was handed over.
    pub(crate) fn note(&mut self, update: &SceneUpdate) {
        match update {
            SceneUpdate::Mesh(tile) => _ = self.tiles.insert(tile.key),
            SceneUpdate::DropMesh(key) => _ = self.tiles.remove(key),
            SceneUpdate::Image(image) => _ = self.images.insert(image.id.clone(), image.level),
            SceneUpdate::DropImage(id) => _ = self.images.remove(id),
            SceneUpdate::Points(chunk) => {
                let normals = (!chunk.positions.is_empty()).then_some(!chunk.normals.is_empty());
                self.nodes.insert(chunk.id, normals);
            }
            SceneUpdate::DropPoints(id) => _ = self.nodes.remove(id),
        }
    }
}

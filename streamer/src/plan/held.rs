//! What the receiver of the updates holds.

use std::collections::{BTreeMap, BTreeSet};

use flaneur_scene::{ImageId, PointNodeId, SceneUpdate, TileKey};

/// The outcome of all updates that were handed over.
#[derive(Clone, Debug, Default)]
pub(crate) struct Held {
    /// Tiles of mesh.
    pub(crate) tiles: BTreeSet<TileKey>,
    /// Photographs: level and pixels.
    pub(crate) images: BTreeMap<ImageId, (u32, u64)>,
    /// Point nodes.
    pub(crate) nodes: BTreeSet<PointNodeId>,
    /// Points of each node, and whether they have normals; none where no point is left.
    pub(crate) points: BTreeMap<PointNodeId, (u64, Option<bool>)>,
}

impl Held {
    /// Takes note of an update.
    pub(crate) fn note(&mut self, update: &SceneUpdate) {
        match update {
            SceneUpdate::Mesh(tile) => _ = self.tiles.insert(tile.key),
            SceneUpdate::DropMesh(key) => _ = self.tiles.remove(key),
            SceneUpdate::Image(image) => {
                let pixels = u64::from(image.size.x) * u64::from(image.size.y);
                self.images.insert(image.id.clone(), (image.level, pixels));
            }
            SceneUpdate::DropImage(id) => _ = self.images.remove(id),
            SceneUpdate::Points(chunk) => {
                let count = chunk.positions.len();
                let normals = (count > 0).then_some(!chunk.normals.is_empty());
                self.nodes.insert(chunk.id);
                self.points.insert(chunk.id, (count as u64, normals));
            }
            SceneUpdate::DropPoints(id) => {
                self.nodes.remove(id);
                self.points.remove(id);
            }
        }
    }

    /// Pixels of all photographs.
    pub(crate) fn pixels(&self) -> u64 {
        self.images.values().map(|(_, pixels)| pixels).sum()
    }

    /// Points of all nodes.
    pub(crate) fn point_count(&self) -> u64 {
        self.points.values().map(|(points, _)| points).sum()
    }
}

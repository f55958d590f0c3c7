//! Who has what of a scene on the device: several streamers feed one renderer, each of which keeps
//! account of its own.

use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};

use flaneur_scene::{ImageId, PointNodeId, SceneUpdate, TileKey};

/// One of those who feed the renderer.
pub(super) type FeederId = u64;

/// What is on the device, and for whom. What several want is there once, as fine as the one that
/// gave it finest had it, until the last of them drops it.
#[derive(Debug, Default)]
pub(super) struct Residents {
    held: HashMap<Key, Held>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Key {
    Mesh(TileKey),
    Image(ImageId),
    Points(PointNodeId),
}

#[derive(Debug)]
struct Held {
    by: BTreeSet<FeederId>,
    /// Larger for what is finer.
    fineness: i64,
}

impl Residents {
    /// Takes note of what `feeder` gives; what the renderer has to be told of it, if anything.
    pub(super) fn give(&mut self, feeder: FeederId, update: SceneUpdate) -> Option<SceneUpdate> {
        let (key, fineness) = key_of(&update);
        match (fineness, self.held.entry(key)) {
            (Some(fineness), Entry::Vacant(place)) => {
                place.insert(Held { by: BTreeSet::from([feeder]), fineness });
                Some(update)
            }
            (Some(fineness), Entry::Occupied(mut place)) => {
                let held = place.get_mut();
                held.by.insert(feeder);
                // Who has it alone decides for itself.
                let replaces = held.by.len() == 1 || fineness > held.fineness;
                if replaces {
                    held.fineness = fineness;
                }
                replaces.then_some(update)
            }
            (None, Entry::Occupied(mut place)) => {
                place.get_mut().by.remove(&feeder);
                if place.get().by.is_empty() {
                    place.remove();
                    return Some(update);
                }
                None
            }
            (None, Entry::Vacant(_)) => None,
        }
    }

    /// The renderer dropped this by itself; who had it.
    pub(super) fn evicted(&mut self, dropped: &SceneUpdate) -> BTreeSet<FeederId> {
        self.held.remove(&key_of(dropped).0).map(|held| held.by).unwrap_or_default()
    }

    /// The renderer has a photograph at `level` only; who has it.
    pub(super) fn coarsened(&mut self, id: &ImageId, level: u32) -> BTreeSet<FeederId> {
        let Some(held) = self.held.get_mut(&Key::Image(id.clone())) else {
            return BTreeSet::new();
        };
        held.fineness = -i64::from(level);
        held.by.clone()
    }

    /// `feeder` has gone; what nobody else has.
    pub(super) fn leave(&mut self, feeder: FeederId) -> Vec<SceneUpdate> {
        let mut dropped = Vec::new();
        self.held.retain(|key, held| {
            let orphaned = held.by.remove(&feeder) && held.by.is_empty();
            if orphaned {
                dropped.push(key.drop());
            }
            !orphaned
        });
        dropped
    }
}

impl Key {
    fn drop(&self) -> SceneUpdate {
        match self {
            Self::Mesh(key) => SceneUpdate::DropMesh(*key),
            Self::Image(id) => SceneUpdate::DropImage(id.clone()),
            Self::Points(id) => SceneUpdate::DropPoints(*id),
        }
    }
}

/// What an update is about, and how fine it is, unless it drops that.
fn key_of(update: &SceneUpdate) -> (Key, Option<i64>) {
    match update {
        SceneUpdate::Mesh(tile) => (Key::Mesh(tile.key), Some(tile.vertices.len() as i64)),
        SceneUpdate::DropMesh(key) => (Key::Mesh(*key), None),
        SceneUpdate::Image(image) => (Key::Image(image.id.clone()), Some(-i64::from(image.level))),
        SceneUpdate::DropImage(id) => (Key::Image(id.clone()), None),
        SceneUpdate::Points(chunk) => (Key::Points(chunk.id), Some(0)),
        SceneUpdate::DropPoints(id) => (Key::Points(*id), None),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use flaneur_scene::{MeshTile, MeshVertex, SurfaceClass, TileLayer};
    use glam::DVec3;

    use super::*;

    const KEY: TileKey = TileKey { layer: TileLayer::Ground, x: 1, y: 2 };

    fn tile(vertices: usize) -> SceneUpdate {
        let vertex = MeshVertex {
            position: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            uncertainty_m: 0.1,
            class: SurfaceClass::Ground,
        };
        let vertices = vec![vertex; vertices];
        SceneUpdate::Mesh(Arc::new(MeshTile {
            key: KEY,
            origin: DVec3::ZERO,
            vertices,
            indices: Vec::new(),
        }))
    }

    fn told(update: Option<SceneUpdate>) -> Option<usize> {
        update.map(|update| match update {
            SceneUpdate::Mesh(tile) => tile.vertices.len(),
            SceneUpdate::DropMesh(KEY) => 0,
            other => panic!("{other:?}"),
        })
    }

    #[test]
    fn the_finest_is_there_until_the_last_drops_it() {
        let mut residents = Residents::default();
        assert_eq!(told(residents.give(1, tile(4))), Some(4));
        assert_eq!(told(residents.give(2, tile(3))), None, "what is there is finer");
        assert_eq!(told(residents.give(2, tile(9))), Some(9));
        assert_eq!(told(residents.give(1, SceneUpdate::DropMesh(KEY))), None, "2 has it");
        assert_eq!(told(residents.give(2, tile(3))), Some(3), "2 has it alone");
        assert_eq!(told(residents.give(3, SceneUpdate::DropMesh(KEY))), None, "3 never had it");
        assert_eq!(told(residents.give(2, SceneUpdate::DropMesh(KEY))), Some(0));
        assert_eq!(told(residents.give(2, SceneUpdate::DropMesh(KEY))), None);
    }

    #[test]
    fn who_leaves_takes_what_nobody_else_has() {
        let mut residents = Residents::default();
        residents.give(1, tile(4));
        residents.give(2, tile(4));
        assert!(residents.leave(1).is_empty());
        assert!(residents.leave(1).is_empty(), "gone already");
        assert!(matches!(residents.leave(2)[..], [SceneUpdate::DropMesh(KEY)]));
        residents.give(1, tile(4));
        residents.give(2, tile(4));
        assert_eq!(residents.evicted(&SceneUpdate::DropMesh(KEY)), BTreeSet::from([1, 2]));
        assert_eq!(told(residents.give(2, tile(2))), Some(2), "it is not there any more");
    }
}

//! Which meshes are given up for others.

use std::cmp::Reverse;

use flaneur_scene::{Bounds3, TileKey};
use glam::DVec3;

use super::MeshStore;

impl MeshStore {
    /// Tiles that together free `lacking` bytes and are all farther from `eye` than `bounds`, of the
    /// tile `key`, farthest first; `None` where those are not enough.
    pub(super) fn farther(
        &self,
        key: TileKey,
        bounds: &Bounds3,
        eye: DVec3,
        lacking: u64,
    ) -> Option<Vec<TileKey>> {
        let distance_m = bounds.distance(eye);
        let others = self.tiles.iter().filter(|(other, _)| **other != key);
        let mut order: Vec<(f64, Reverse<TileKey>, u64)> = others
            .map(|(other, tile)| (tile.bounds.distance(eye), Reverse(*other), tile.bytes()))
            .filter(|(other_m, ..)| *other_m > distance_m)
            .collect();
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut freed = 0;
        let mut given_up = Vec::new();
        for (_, Reverse(other), bytes) in order {
            if freed >= lacking {
                break;
            }
            freed += bytes;
            given_up.push(other);
        }
        (freed >= lacking).then_some(given_up)
    }
}

//! Which points are given up for others.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use flaneur_scene::{Bounds3, PointNodeId};
use glam::DVec3;

use super::PointStore;
use super::kin::ancestors;

/// Nearer than this a node is not more useful, metres.
const NEAREST_M: f64 = 0.5;

impl PointStore {
    /// Chunks that together free `lacking` blocks and are all less useful than the chunk `id`; `None`
    /// where those are not enough.
    ///
    /// A chunk is as useful as its points appear far apart from `eye`, and no more than those above
    /// it, so that the finest and farthest go first and none before those below it.
    pub(super) fn less_useful(
        &self,
        id: PointNodeId,
        spacing_m: f32,
        bounds: &Bounds3,
        eye: DVec3,
        lacking: u64,
    ) -> Option<Vec<PointNodeId>> {
        if lacking == 0 {
            return Some(Vec::new());
        }
        let apart = |spacing_m: f32, bounds: &Bounds3| {
            f64::from(spacing_m) / bounds.distance(eye).max(NEAREST_M)
        };
        let mut useful: BTreeMap<PointNodeId, f64> = BTreeMap::new();
        let bounded = |useful: &BTreeMap<PointNodeId, f64>, id, own: f64| {
            ancestors(id).find_map(|above| useful.get(&above)).map_or(own, |above| own.min(*above))
        };
        // In their order, which has those above first.
        for (other, chunk) in &self.chunks {
            let own = apart(chunk.spacing_m, &chunk.bounds);
            useful.insert(*other, bounded(&useful, *other, own));
        }
        let own = bounded(&useful, id, apart(spacing_m, bounds));
        let mut order: Vec<(f64, Reverse<PointNodeId>)> = useful
            .into_iter()
            .filter(|(other, useful)| *other != id && *useful < own)
            .map(|(other, useful)| (useful, Reverse(other)))
            .collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut freed = 0;
        let mut given_up = Vec::new();
        for (_, Reverse(other)) in order {
            if freed >= lacking {
                break;
            }
            freed += self.chunks.get(&other).map_or(0, |chunk| chunk.boxes.len() as u64);
            given_up.push(other);
        }
        (freed >= lacking).then_some(given_up)
    }
}

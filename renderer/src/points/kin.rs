//! Which resident nodes lie below which others.

use std::collections::{BTreeMap, BTreeSet};

use flaneur_scene::{NodeKey, PointNodeId};

/// The resident descendants of every node, resident or not.
#[derive(Debug, Default)]
pub(crate) struct Kin {
    below: BTreeMap<PointNodeId, BTreeSet<PointNodeId>>,
}

impl Kin {
    pub(crate) fn insert(&mut self, id: PointNodeId) {
        for above in ancestors(id) {
            self.below.entry(above).or_default().insert(id);
        }
    }

    pub(crate) fn remove(&mut self, id: PointNodeId) {
        for above in ancestors(id) {
            if let Some(below) = self.below.get_mut(&above) {
                below.remove(&id);
                if below.is_empty() {
                    self.below.remove(&above);
                }
            }
        }
    }

    /// In their order.
    pub(crate) fn below(&self, id: PointNodeId) -> impl Iterator<Item = PointNodeId> {
        self.below.get(&id).into_iter().flatten().copied()
    }
}

/// The nodes above, nearest first.
pub(crate) fn ancestors(id: PointNodeId) -> impl Iterator<Item = PointNodeId> {
    std::iter::successors(id.key.parent(), NodeKey::parent)
        .map(move |key| PointNodeId { source: id.source, key })
        .take(NodeKey::MAX_LEVEL as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_below_share_the_cell() {
        let id = |level, x| PointNodeId { source: 0, key: NodeKey { level, x, y: 0, z: 0 } };
        let mut kin = Kin::default();
        let other_source = PointNodeId { source: 1, ..id(3, 5) };
        for id in [id(3, 5), id(1, 1), other_source] {
            kin.insert(id);
        }
        let below = |kin: &Kin, id| kin.below(id).collect::<Vec<_>>();
        assert_eq!(below(&kin, id(0, 0)), [id(1, 1), id(3, 5)]);
        assert_eq!(below(&kin, id(1, 1)), [id(3, 5)]);
        assert_eq!(below(&kin, id(2, 2)), [id(3, 5)], "not resident itself");
        assert_eq!(below(&kin, id(1, 0)), []);
        assert_eq!(below(&kin, id(3, 5)), []);
        kin.remove(id(3, 5));
        assert_eq!(below(&kin, id(0, 0)), [id(1, 1)]);
        kin.remove(id(1, 1));
        kin.remove(other_source);
        assert!(kin.below.is_empty());
        let above: Vec<_> = ancestors(id(2, 3)).collect();
        assert_eq!(above, [id(1, 1), id(0, 0)]);
    }
}

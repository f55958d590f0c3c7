//! Point nodes: coarse to fine, by how far apart their points appear in the view.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use flaneur_proto::FieldError;
use flaneur_scene::{Node, NodeKey, PointNodeId, PointSource, View};

use super::cone::ViewCone;
use crate::FetchLimits;
use crate::client::HierarchyEntry;

/// How much less a node counts that the view does not see. It still hides things from
/// photographs, so a coarse form of it is wanted.
const UNSEEN: f64 = 0.25;
/// Nearer than this a node does not gain, metres.
const NEAREST_M: f64 = 0.5;
/// Entries of all loaded pages together.
const MAX_ENTRIES: usize = 16_000_000;

/// The parts of all sources' hierarchies that have been loaded.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy {
    entries: HashMap<PointNodeId, HierarchyEntry>,
}

/// A node to be shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WantedNode {
    /// Which.
    pub(crate) id: PointNodeId,
    /// Its size.
    pub(crate) node: Node,
}

impl Hierarchy {
    /// Adds the page whose root is `page`. An error names an entry outside of it.
    pub(crate) fn insert(
        &mut self,
        page: PointNodeId,
        entries: Vec<HierarchyEntry>,
    ) -> Result<(), FieldError> {
        if self.entries.len() + entries.len() > MAX_ENTRIES {
            let problem = format!("are too many: more than {MAX_ENTRIES} in all pages");
            return Err(FieldError::new("entries", problem));
        }
        // A page without its own root is an empty one, and must not be asked for again.
        let empty = Node { key: page.key, point_count: 0, byte_size: 0, crc32: 0 };
        self.entries.insert(page, HierarchyEntry::Node(empty));
        for (index, entry) in entries.into_iter().enumerate() {
            let (key, is_page) = match entry {
                HierarchyEntry::Node(node) => (node.key, false),
                HierarchyEntry::Page(key) => (key, true),
            };
            let inside = is_at_or_below(key, page.key) && !(is_page && key == page.key);
            if !inside {
                let field = format!("entries[{index}].key");
                let problem = format!("is {key:?}, outside of page {:?}", page.key);
                return Err(FieldError::new(field, problem));
            }
            let id = PointNodeId { source: page.source, key };
            // What is loaded already says more than a reference to it.
            if !is_page || !self.entries.contains_key(&id) {
                self.entries.insert(id, entry);
            }
        }
        Ok(())
    }
}

/// The nodes that `view` wants, most important first, or the pages that must be loaded before
/// that is known.
///
/// A node's importance is the distance in pixels between its points, as they would appear at
/// the nearest point of its cell, a quarter of that where the view does not see it. It halves at
/// least from a node to its children, so that every node follows its ancestors. A node
/// is wanted while its parent's points appear more than [`FetchLimits::point_spacing_px`] apart, it
/// lies within the radius, and the limit of points is not reached.
pub(crate) fn choose_nodes(
    hierarchy: &Hierarchy,
    sources: &[PointSource],
    view: &View,
    limits: &FetchLimits,
) -> Result<Vec<WantedNode>, Vec<PointNodeId>> {
    let measure = Measure { view, cone: ViewCone::new(view), sources };
    let mut queue = BinaryHeap::new();
    for source in 0..u16::try_from(sources.len()).unwrap_or(u16::MAX) {
        queue.extend(measure.candidate(PointNodeId { source, key: NodeKey::ROOT }, limits));
    }
    let (mut wanted, mut missing, mut points) = (Vec::new(), Vec::new(), 0u64);
    while let Some(candidate) = queue.pop() {
        let id = candidate.id;
        let node = match hierarchy.entries.get(&id) {
            Some(HierarchyEntry::Node(node)) => *node,
            Some(HierarchyEntry::Page(_)) => {
                missing.push(id);
                continue;
            }
            None if id.key == NodeKey::ROOT => {
                missing.push(id);
                continue;
            }
            None => continue,
        };
        points += u64::from(node.point_count);
        if points > limits.points {
            break;
        }
        if node.point_count > 0 {
            wanted.push(WantedNode { id, node });
        }
        let refined = candidate.spacing_px > limits.point_spacing_px;
        if refined && id.key.level < NodeKey::MAX_LEVEL {
            for key in id.key.children() {
                let child = PointNodeId { source: id.source, key };
                if hierarchy.entries.contains_key(&child) {
                    queue.extend(measure.candidate(child, limits));
                }
            }
        }
    }
    if missing.is_empty() { Ok(wanted) } else { Err(missing) }
}

struct Measure<'a> {
    view: &'a View,
    cone: ViewCone,
    sources: &'a [PointSource],
}

impl Measure<'_> {
    /// The node with its importance, `None` beyond the radius.
    fn candidate(&self, id: PointNodeId, limits: &FetchLimits) -> Option<Candidate> {
        let cube = &self.sources.get(usize::from(id.source))?.cube;
        let bounds = cube.node_bounds(id.key);
        let distance = bounds.distance(self.view.eye());
        if !(distance <= limits.point_radius_m) {
            return None;
        }
        let seen = if self.cone.meets(&bounds) { 1.0 } else { UNSEEN };
        let density = self.view.pixels_a_metre(distance.max(NEAREST_M));
        let spacing = cube.level_spacing_m(id.key.level);
        Some(Candidate { spacing_px: seen * density * spacing, id })
    }
}

#[derive(Debug, PartialEq)]
struct Candidate {
    spacing_px: f64,
    id: PointNodeId,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.spacing_px.total_cmp(&other.spacing_px).then(other.id.cmp(&self.id))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

fn is_at_or_below(key: NodeKey, root: NodeKey) -> bool {
    let Some(depth) = key.level.checked_sub(root.level) else { return false };
    let above = |cell: u32| cell.checked_shr(depth).unwrap_or(0);
    (above(key.x), above(key.y), above(key.z)) == (root.x, root.y, root.z)
}

#[cfg(test)]
mod tests;

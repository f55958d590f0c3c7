//! Point nodes: coarse to fine, by how far apart their points appear in the view.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

use flaneur_scene::{Node, NodeKey, PointNodeId, PointSource, View};
use glam::DVec3;

use super::cone::ViewCone;
use super::gaze::Gaze;
use super::hierarchy::{Hierarchy, Index};
use crate::ViewRequest;
use crate::client::HierarchyEntry;

/// How much less a node counts that the view does not see. It still hides things from
/// photographs, so a coarse form of it is wanted.
const UNSEEN: f64 = 0.25;
/// Nearer than this a node does not gain, metres.
const NEAREST_M: f64 = 0.5;
/// Half the diagonal of a cube over its edge.
const HALF_DIAGONAL: f64 = 0.866_025_403_784_438_6;

/// A node to be shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WantedNode {
    /// Which.
    pub id: PointNodeId,
    /// Its size.
    pub node: Node,
    /// From the eye to the middle of its cell, metres.
    pub distance_m: f64,
    /// Between its points, metres.
    pub spacing_m: f64,
    /// Whether the view may see something of it.
    pub seen: bool,
}

/// What a view wants of the points, as far as that is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChosenNodes {
    /// Most important first.
    pub wanted: Vec<WantedNode>,
    /// Pages that must be loaded before more is known.
    pub missing: Vec<PointNodeId>,
}

/// The nodes that a view wants, most important first.
///
/// A node's importance is its screen-space error: the distance in pixels between its points, as
/// they would appear at the nearest point of its cell, a quarter of that where the view does not
/// see it, and less beside the gaze where the request weighs it. It halves at least from a node to
/// its children, so that every node follows its ancestors. A node is wanted while its parent's
/// importance is above [`FetchLimits::point_spacing_px`], it lies within the radius, and the limits
/// of points and bytes are not reached.
///
/// Nodes that are `held` count [`ViewRequest::steadiness`] times as much, so that nothing comes and
/// goes at a threshold.
///
/// [`FetchLimits::point_spacing_px`]: crate::FetchLimits::point_spacing_px
pub fn choose_nodes(
    hierarchy: &Hierarchy,
    sources: &[PointSource],
    request: &ViewRequest,
    held: &BTreeSet<PointNodeId>,
) -> ChosenNodes {
    let limits = &request.limits;
    let measure = Measure::new(request, sources, held);
    let mut queue = BinaryHeap::new();
    let mut chosen = ChosenNodes::default();
    for source in 0..u16::try_from(sources.len()).unwrap_or(u16::MAX) {
        let id = PointNodeId { source, key: NodeKey::ROOT };
        match hierarchy.root(source) {
            Some(index) => queue.extend(measure.candidate(id, index)),
            None if measure.reaches(id) => chosen.missing.push(id),
            None => {}
        }
    }
    let (mut points, mut bytes) = (0u64, 0u64);
    while let Some(candidate) = queue.pop() {
        let id = candidate.id;
        let HierarchyEntry::Node(node) = hierarchy.entry(candidate.index) else {
            chosen.missing.push(id);
            continue;
        };
        points += u64::from(node.point_count);
        bytes += u64::from(node.byte_size);
        if points > limits.points || bytes > limits.point_bytes {
            break;
        }
        if node.point_count > 0 {
            chosen.wanted.push(candidate.wanted(node));
        }
        if candidate.importance > limits.point_spacing_px && id.key.level < NodeKey::MAX_LEVEL {
            // A node is held whether or not what is below it is: that itself decides whether it stays.
            let refines = candidate.unsteadied > limits.point_spacing_px;
            for index in hierarchy.children(candidate.index) {
                let key = match hierarchy.entry(index) {
                    HierarchyEntry::Node(node) => node.key,
                    HierarchyEntry::Page(key) => key,
                };
                let id = PointNodeId { key, ..id };
                if refines || held.contains(&id) {
                    queue.extend(measure.candidate(id, index));
                }
            }
        }
    }
    chosen
}

struct Measure<'a> {
    request: &'a ViewRequest,
    cone: ViewCone,
    gaze: Gaze,
    sources: &'a [PointSource],
    held: &'a BTreeSet<PointNodeId>,
}

impl<'a> Measure<'a> {
    fn new(
        request: &'a ViewRequest,
        sources: &'a [PointSource],
        held: &'a BTreeSet<PointNodeId>,
    ) -> Self {
        let cone = ViewCone::new(&request.view);
        let gaze = Gaze::new(&request.view, request.gaze.pixel(), &cone);
        Self { request, cone, gaze, sources, held }
    }

    /// Whether a node is near enough to be looked at.
    fn reaches(&self, id: PointNodeId) -> bool {
        self.sources.get(usize::from(id.source)).is_some_and(|source| {
            let bounds = source.cube.node_bounds(id.key);
            bounds.distance(self.view().eye()) <= self.request.limits.point_radius_m
        })
    }

    /// The node with its importance, `None` beyond the radius.
    fn candidate(&self, id: PointNodeId, index: Index) -> Option<Candidate> {
        let cube = &self.sources.get(usize::from(id.source))?.cube;
        let bounds = cube.node_bounds(id.key);
        let steady = self.request.steadiness > 1.0 && self.held.contains(&id);
        let steadiness = if steady { self.request.steadiness } else { 1.0 };
        let distance = bounds.distance(self.view().eye());
        if !(distance <= self.request.limits.point_radius_m * steadiness) {
            return None;
        }
        let centre: DVec3 = bounds.centre() - self.view().eye();
        let radius = HALF_DIAGONAL * (bounds.max.x - bounds.min.x);
        let spacing_m = cube.level_spacing_m(id.key.level);
        let spacing_px = self.view().pixels_a_metre(distance.max(NEAREST_M)) * spacing_m;
        let importance = |steadiness: f64| {
            // What is held stays in sight a little longer, too.
            let radius = radius * steadiness;
            let seen = self.cone.meets_ball(centre, radius);
            let gazed =
                if self.request.gaze.weighs() { self.gaze.weight(centre, radius) } else { 1.0 };
            (spacing_px * gazed * steadiness * if seen { 1.0 } else { UNSEEN }, seen)
        };
        let (importance, unsteadied, seen) = if steady {
            let ((steadied, seen), (unsteadied, _)) = (importance(steadiness), importance(1.0));
            (steadied, unsteadied, seen)
        } else {
            let (importance, seen) = importance(1.0);
            (importance, importance, seen)
        };
        let distance_m = centre.length();
        Some(Candidate { importance, unsteadied, id, index, distance_m, spacing_m, seen })
    }

    fn view(&self) -> &View {
        &self.request.view
    }
}

#[derive(Debug, PartialEq)]
struct Candidate {
    importance: f64,
    /// The same if it were not held.
    unsteadied: f64,
    id: PointNodeId,
    index: Index,
    distance_m: f64,
    spacing_m: f64,
    seen: bool,
}

impl Candidate {
    fn wanted(&self, node: Node) -> WantedNode {
        WantedNode {
            id: self.id,
            node,
            distance_m: self.distance_m,
            spacing_m: self.spacing_m,
            seen: self.seen,
        }
    }
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.importance.total_cmp(&other.importance).then(other.id.cmp(&self.id))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests;

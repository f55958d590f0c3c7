//! The surveyed point at a place, of those that a picture shows.

use std::sync::Arc;

use flaneur_scene::{Bounds3, Node, NodeKey, PointNodeId};
use glam::DVec3;

use super::understand::{Context, Understood};
use super::{fetched, one};
use crate::StreamError;
use crate::choose::WantedNode;
use crate::client::HierarchyEntry;
use crate::decode::{SurveyedPoint, Track, nearest_point};
use crate::load::Loader;
use crate::plan::Part;
use crate::survey::Target;

/// Stations within reach of a place move its points by less than this, metres.
const FARTHEST_M: f64 = 200.0;

/// The point shown nearest to `place` (world) and within `reach_m` of it, of the nodes that are `shown`. What
/// has been fetched is found in the cache.
pub(crate) async fn point_at(
    loader: &Arc<Loader>,
    place: DVec3,
    reach_m: f64,
    shown: &(dyn Fn(&PointNodeId) -> bool + Sync),
) -> Result<Option<SurveyedPoint>, StreamError> {
    let mut best: Option<(f64, SurveyedPoint)> = None;
    let scene = Arc::clone(loader.scene());
    for (index, source) in (0u16..).zip(&scene.point_sources) {
        // No point moves as far as that.
        if !reaches(&source.bounds, place, reach_m + FARTHEST_M) {
            continue;
        }
        let track = track_of(loader, index).await?;
        let stored_m = reach_m + track.farthest_m(place);
        for node in nodes_at(loader, index, place, stored_m).await? {
            let id = PointNodeId { source: index, key: node.key };
            if node.point_count == 0 || !shown(&id) {
                continue;
            }
            let bounds = source.cube.node_bounds(node.key);
            let target = Target::Node(WantedNode {
                id,
                node,
                distance_m: bounds.centre().distance(place),
                spacing_m: source.cube.level_spacing_m(node.key.level),
                seen: true,
            });
            let (of_scene, track) = (Arc::clone(&scene), Arc::clone(&track));
            let decode = move |chunk: &[u8]| {
                let source = of_scene.point_sources.get(usize::from(index));
                source.map_or(Ok(None), |s| nearest_point(s, &node, chunk, &track, place))
            };
            let Some((distance_m, point)) = fetched(loader, Part::Node(id), target, decode).await?
            else {
                continue;
            };
            let nearest_m = best.as_ref().map_or(reach_m, |(nearest_m, _)| *nearest_m);
            if distance_m <= nearest_m {
                best = Some((distance_m, point));
            }
        }
    }
    Ok(best.map(|(_, point)| point))
}

/// Where a source was taken from.
async fn track_of(loader: &Arc<Loader>, source: u16) -> Result<Arc<Track>, StreamError> {
    let scene = Arc::clone(loader.scene());
    let context = Context { scene, mask: None, track: None, normals: false };
    match one(loader, Part::Stations(source), Target::Named, context).await? {
        Understood::Stations(track) => Ok(track),
        _ => Ok(Arc::new(Track::through(&[]))),
    }
}

/// The nodes of a source whose cells come within `reach_m` of `place`.
async fn nodes_at(
    loader: &Arc<Loader>,
    source: u16,
    place: DVec3,
    reach_m: f64,
) -> Result<Vec<Node>, StreamError> {
    let scene = Arc::clone(loader.scene());
    let Some(cube) = scene.point_sources.get(usize::from(source)).map(|source| source.cube) else {
        return Ok(Vec::new());
    };
    let near = |key: &NodeKey| reaches(&cube.node_bounds(*key), place, reach_m);
    let (mut nodes, mut pages) = (Vec::new(), vec![NodeKey::ROOT]);
    let mut opened = Vec::new();
    while let Some(page) = pages.pop() {
        // A page that leads back to one before it leads nowhere.
        if opened.contains(&page) {
            continue;
        }
        opened.push(page);
        let part = Part::Page(PointNodeId { source, key: page });
        let context =
            Context { scene: Arc::clone(&scene), mask: None, track: None, normals: false };
        let Understood::Page(entries) = one(loader, part, Target::Named, context).await? else {
            continue;
        };
        for entry in entries {
            match entry {
                HierarchyEntry::Node(node) if near(&node.key) => nodes.push(node),
                HierarchyEntry::Page(key) if near(&key) => pages.push(key),
                HierarchyEntry::Node(_) | HierarchyEntry::Page(_) => {}
            }
        }
    }
    Ok(nodes)
}

fn reaches(bounds: &Bounds3, place: DVec3, reach_m: f64) -> bool {
    place.cmpge(bounds.min - reach_m).all() && place.cmple(bounds.max + reach_m).all()
}

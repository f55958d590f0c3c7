use super::super::hierarchy::is_at_or_below;
use super::*;
use crate::{FetchLimits, Gaze};
use flaneur_scene::{Bounds3, GpsTimeKind, OctreeCube};
use glam::UVec2;
use proptest::prelude::*;

fn source(centre: DVec3) -> PointSource {
    PointSource {
        name: "drive".into(),
        point_count: 0,
        bounds: Bounds3 { min: centre - 64.0, max: centre + 64.0 },
        cube: OctreeCube { centre, half_size_m: 64.0, spacing_m: 2.0 },
        point_format: 7,
        record_length: 36,
        scale: DVec3::splat(0.001),
        offset: centre,
        laszip_vlr: Vec::new(),
        extra_bytes_vlr: Vec::new(),
        gps_time: GpsTimeKind::Week,
    }
}

/// Every node down to `depth` near the plane z = 0, each with `count` points.
fn street(depth: u32, count: u32) -> Vec<HierarchyEntry> {
    let cube = source(DVec3::ZERO).cube;
    let (mut entries, mut level) = (Vec::new(), vec![NodeKey::ROOT]);
    for _ in 0..=depth {
        let node =
            |&key: &NodeKey| Node { key, point_count: count, byte_size: 8 * count, crc32: 0 };
        entries.extend(level.iter().map(node).map(HierarchyEntry::Node));
        let below = level.iter().flat_map(NodeKey::children);
        level = below
            .filter(|&key| {
                let bounds = cube.node_bounds(key);
                bounds.min.z <= 0.0 && bounds.max.z >= 0.0
            })
            .collect();
    }
    entries
}

fn root(source: u16) -> PointNodeId {
    PointNodeId { source, key: NodeKey::ROOT }
}

fn loaded(entries: Vec<HierarchyEntry>) -> Hierarchy {
    let mut hierarchy = Hierarchy::default();
    hierarchy.insert(root(0), entries).expect("all below the root");
    hierarchy
}

fn ask(view: View, limits: FetchLimits) -> ViewRequest {
    ViewRequest { limits, ..ViewRequest::new(view) }
}

fn choose(hierarchy: &Hierarchy, request: &ViewRequest) -> ChosenNodes {
    choose_nodes(hierarchy, &[source(DVec3::ZERO)], request, &BTreeSet::new())
}

fn ids(chosen: &ChosenNodes) -> BTreeSet<PointNodeId> {
    chosen.wanted.iter().map(|wanted| wanted.id).collect()
}

proptest! {
    /// Wherever one stands, looks and gazes, and whatever is held: ancestors first, importance
    /// falling, the limits kept, and the same choice every time.
    #[test]
    fn coarse_comes_before_fine(
        x in -100.0..100.0, y in -100.0..100.0, z in -5.0..50.0,
        heading in 0.0..6.3, pitch in -1.5..1.5, fov in 0.2..2.5,
        points in 0u64..30_000, radius in 0.0..200.0, point_bytes in 0u64..300_000,
        gaze in prop::option::of((0.0..640.0, 0.0..320.0)), steadiness in 1.0..2.0,
        before in (-100.0..100.0, 0.0..6.3),
    ) {
        let hierarchy = loaded(street(5, 100));
        let sources = [source(DVec3::ZERO)];
        let size = UVec2::new(640, 320);
        let view = View::look(DVec3::new(x, y, z), heading, pitch, fov, size);
        let limits =
            FetchLimits { points, point_bytes, point_radius_m: radius, ..FetchLimits::default() };
        let gaze = gaze.map_or(Gaze::Everywhere, |(x, y)| Gaze::At((x, y).into()));
        let request = ViewRequest { gaze, steadiness, ..ask(view, limits) };
        let earlier = View::look(DVec3::new(before.0, y, z), before.1, pitch, fov, size);
        let held = ids(&choose(&hierarchy, &ask(earlier, limits)));
        let chosen = choose_nodes(&hierarchy, &sources, &request, &held);
        prop_assert!(chosen.missing.is_empty());
        let mut seen = std::collections::HashSet::new();
        let measure = Measure::new(&request, &sources, &held);
        let root = hierarchy.root(0).expect("loaded");
        let mut last = f64::INFINITY;
        for wanted in &chosen.wanted {
            let id = wanted.id;
            prop_assert_eq!(id.key, wanted.node.key);
            if let Some(parent) = id.key.parent() {
                let parent = PointNodeId { key: parent, ..id };
                prop_assert!(seen.contains(&parent), "{:?} before its parent", id.key);
            }
            prop_assert!(seen.insert(id), "{:?} twice", id.key);
            let importance = measure.candidate(id, root).expect("within reach").importance;
            prop_assert!(importance <= last * (1.0 + 1e-12));
            last = importance;
        }
        let total: u64 = chosen.wanted.iter().map(|w| u64::from(w.node.point_count)).sum();
        let bytes: u64 = chosen.wanted.iter().map(|w| u64::from(w.node.byte_size)).sum();
        prop_assert!(total <= points && bytes <= point_bytes);
        prop_assert_eq!(choose_nodes(&hierarchy, &sources, &request, &held), chosen);
    }

    /// A view that wavers by a few centimetres comes to rest: what one of its ends brings, the other
    /// leaves.
    #[test]
    fn nothing_flickers_at_a_threshold(
        x in -60.0..60.0, heading in 0.0..6.3, aside in -0.02..0.02, ahead in -0.02..0.02,
        points in 1_000u64..30_000,
    ) {
        let hierarchy = loaded(street(5, 100));
        let sources = [source(DVec3::ZERO)];
        let limits = FetchLimits { points, ..FetchLimits::default() };
        let steady = |eye| {
            let view = View::look(eye, heading, 0.0, 1.0, UVec2::new(640, 320));
            ViewRequest { limits, ..ViewRequest::walking(view) }
        };
        let eye = DVec3::new(x, 3.0, 1.7);
        let ends = [steady(eye), steady(eye + DVec3::new(aside, ahead, 0.0))];
        let mut held = BTreeSet::new();
        // What comes may bring what is below it the next time, level by level.
        for request in ends.iter().cycle().take(16) {
            held = ids(&choose_nodes(&hierarchy, &sources, request, &held));
        }
        for request in &ends {
            let then = ids(&choose_nodes(&hierarchy, &sources, request, &held));
            let changed: Vec<_> = held.symmetric_difference(&then).collect();
            prop_assert!(changed.is_empty(), "flickers: {changed:?}");
        }
    }
}

#[test]
fn beside_the_gaze_less_is_wanted() {
    let hierarchy = loaded(street(5, 100));
    let view = View::look(DVec3::new(0.0, -40.0, 2.0), 0.0, 0.0, 1.2, UVec2::new(640, 320));
    let limits = FetchLimits { point_spacing_px: 1.5, ..FetchLimits::default() };
    let at = |gaze| choose(&hierarchy, &ViewRequest { gaze, ..ask(view, limits) });
    let everywhere = at(Gaze::Everywhere);
    let (left, right) = (at(Gaze::At((0.0, 160.0).into())), at(Gaze::At((640.0, 160.0).into())));
    assert!(ids(&left).is_subset(&ids(&everywhere)) && left.wanted.len() < everywhere.wanted.len());
    let west = |chosen: &ChosenNodes| {
        chosen.wanted.iter().filter(|w| w.id.key.level == 5 && w.id.key.x < 16).count()
    };
    assert!(west(&left) > west(&right), "{} {}", west(&left), west(&right));
}

#[test]
fn refinement_ends_where_points_appear_close_enough() {
    let hierarchy = loaded(street(5, 100));
    let view = View::look(DVec3::new(0.0, -60.0, 2.0), 0.0, 0.0, 1.0, UVec2::new(640, 320));
    let all = FetchLimits { points: u64::MAX, ..FetchLimits::default() };
    let finest = |spacing_px: f64| {
        let limits = FetchLimits { point_spacing_px: spacing_px, ..all };
        let wanted = choose(&hierarchy, &ask(view, limits)).wanted;
        (wanted.iter().map(|w| w.id.key.level).max(), wanted.len())
    };
    assert_eq!(finest(1e9), (Some(0), 1));
    let (coarse, fine) = (finest(20.0), finest(1.0));
    assert!(coarse.1 < fine.1, "{coarse:?} {fine:?}");
    assert_eq!(fine.0, Some(5));
}

/// A hierarchy in pages gives the same choice as the same hierarchy in one.
#[test]
fn pages_are_asked_for_and_change_nothing() {
    let entries = street(4, 100);
    let is_deep =
        |entry: &HierarchyEntry| matches!(entry, HierarchyEntry::Node(n) if n.key.level >= 2);
    let mut top: Vec<_> = entries.iter().copied().filter(|e| !is_deep(e)).collect();
    let keys = |level: u32| {
        entries.iter().filter_map(move |e| match e {
            HierarchyEntry::Node(n) if n.key.level == level => Some(n.key),
            _ => None,
        })
    };
    top.extend(keys(2).map(HierarchyEntry::Page));
    let mut paged = loaded(top);
    let view = View::look(DVec3::new(0.0, -60.0, 2.0), 0.3, 0.0, 1.0, UVec2::new(640, 320));
    let request = ask(view, FetchLimits { points: 12_000, ..FetchLimits::default() });
    let mut rounds = 0;
    let wanted = loop {
        let chosen = choose(&paged, &request);
        if chosen.missing.is_empty() {
            break chosen.wanted;
        }
        for page in chosen.missing {
            let inside = |e: &&HierarchyEntry| matches!(e, HierarchyEntry::Node(n) if is_at_or_below(n.key, page.key));
            let entries = entries.iter().filter(inside).copied().collect();
            paged.insert(page, entries).expect("inside the page");
        }
        rounds += 1;
        assert!(rounds < 100);
    };
    assert!(rounds > 0, "pages were needed");
    assert_eq!(wanted, choose(&loaded(entries), &request).wanted);
}

#[test]
fn entries_outside_their_page_are_refused() {
    let mut hierarchy = Hierarchy::default();
    let page = PointNodeId { source: 0, key: NodeKey { level: 1, x: 1, y: 0, z: 0 } };
    let outside = NodeKey { level: 2, x: 0, y: 0, z: 0 };
    let refuse = |hierarchy: &mut Hierarchy, entry| {
        hierarchy.insert(page, vec![entry]).expect_err("outside").field
    };
    let node = |key| HierarchyEntry::Node(Node { key, point_count: 1, byte_size: 1, crc32: 0 });
    assert_eq!(refuse(&mut hierarchy, node(outside)), "entries[0].key");
    assert_eq!(refuse(&mut hierarchy, node(NodeKey::ROOT)), "entries[0].key");
    // A page that refers to itself would be asked for without end.
    assert_eq!(refuse(&mut hierarchy, HierarchyEntry::Page(page.key)), "entries[0].key");
    // A page that says nothing, too.
    hierarchy.insert(root(0), Vec::new()).expect("empty");
    let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::new(64, 64));
    let chosen = choose(&hierarchy, &ask(view, FetchLimits::default()));
    assert_eq!(chosen, ChosenNodes::default());
}

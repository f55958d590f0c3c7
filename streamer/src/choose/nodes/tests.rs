use super::*;
use flaneur_scene::{Bounds3, OctreeCube};
use glam::{DVec3, UVec2};
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

proptest! {
    /// Wherever one stands and looks: ancestors first, importance falling, the limits kept,
    /// and the same choice every time.
    #[test]
    fn coarse_comes_before_fine(
        x in -100.0..100.0, y in -100.0..100.0, z in -5.0..50.0,
        heading in 0.0..6.3, pitch in -1.5..1.5, fov in 0.2..2.5,
        points in 0u64..30_000, radius in 0.0..200.0,
    ) {
        let hierarchy = loaded(street(5, 100));
        let sources = [source(DVec3::ZERO)];
        let view =
            View::look(DVec3::new(x, y, z), heading, pitch, fov, UVec2::new(640, 320));
        let limits = FetchLimits { points, point_radius_m: radius, ..FetchLimits::default() };
        let wanted = choose_nodes(&hierarchy, &sources, &view, &limits).expect("all is loaded");
        let mut seen = std::collections::HashSet::new();
        let measure = Measure { view: &view, cone: ViewCone::new(&view), sources: &sources };
        let mut last = f64::INFINITY;
        for WantedNode { id, node } in &wanted {
            prop_assert_eq!(id.key, node.key);
            if let Some(parent) = id.key.parent() {
                prop_assert!(seen.contains(&parent), "{:?} before its parent", id.key);
            }
            prop_assert!(seen.insert(id.key), "{:?} twice", id.key);
            let spacing = measure.candidate(*id, &limits).expect("within the radius").spacing_px;
            prop_assert!(spacing <= last);
            last = spacing;
        }
        let total: u64 = wanted.iter().map(|w| u64::from(w.node.point_count)).sum();
        prop_assert!(total <= points);
        prop_assert_eq!(choose_nodes(&hierarchy, &sources, &view, &limits), Ok(wanted));
    }
}

#[test]
fn refinement_ends_where_points_appear_close_enough() {
    let hierarchy = loaded(street(5, 100));
    let sources = [source(DVec3::ZERO)];
    let view = View::look(DVec3::new(0.0, -60.0, 2.0), 0.0, 0.0, 1.0, UVec2::new(640, 320));
    let all = FetchLimits { points: u64::MAX, ..FetchLimits::default() };
    let finest = |spacing_px: f64| {
        let limits = FetchLimits { point_spacing_px: spacing_px, ..all };
        let wanted = choose_nodes(&hierarchy, &sources, &view, &limits).expect("loaded");
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
    let sources = [source(DVec3::ZERO)];
    let view = View::look(DVec3::new(0.0, -60.0, 2.0), 0.3, 0.0, 1.0, UVec2::new(640, 320));
    let limits = FetchLimits { points: 12_000, ..FetchLimits::default() };
    let mut rounds = 0;
    let wanted = loop {
        match choose_nodes(&paged, &sources, &view, &limits) {
            Ok(wanted) => break wanted,
            Err(missing) => {
                for page in missing {
                    let inside = |e: &&HierarchyEntry| matches!(e, HierarchyEntry::Node(n) if is_at_or_below(n.key, page.key));
                    let entries = entries.iter().filter(inside).copied().collect();
                    paged.insert(page, entries).expect("inside the page");
                }
            }
        }
        rounds += 1;
        assert!(rounds < 100);
    };
    assert!(rounds > 0, "pages were needed");
    assert_eq!(Ok(wanted), choose_nodes(&loaded(entries), &sources, &view, &limits));
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
    let sources = [source(DVec3::ZERO)];
    assert_eq!(choose_nodes(&hierarchy, &sources, &view, &FetchLimits::default()), Ok(Vec::new()));
}

//! How long it takes to choose the point nodes of a view: `cargo bench --bench selection`.
//!
//! The octree is that of a street of 4 km: nodes near a surface, down to 4 cm between points.

use std::collections::BTreeSet;
use std::time::Instant;

use flaneur_scene::{
    Bounds3, GpsTimeKind, Node, NodeKey, OctreeCube, PointNodeId, PointSource, View,
};
use flaneur_streamer::{FetchLimits, Hierarchy, HierarchyEntry, ViewRequest, choose_nodes};
use glam::{DVec3, UVec2};

/// Nodes of the octree, at least.
const NODES: usize = 100_000;
/// Points of each.
const POINTS: u32 = 4_000;
/// Views along the street.
const VIEWS: usize = 400;

fn main() {
    let source = street();
    let entries = nodes(&source.cube);
    let (count, length_m) = (entries.len(), 2.0 * source.cube.half_size_m);
    let mut hierarchy = Hierarchy::default();
    let root = PointNodeId { source: 0, key: NodeKey::ROOT };
    hierarchy.insert(root, entries).expect("all below the root");
    let everything = FetchLimits {
        points: u64::MAX,
        point_radius_m: f64::INFINITY,
        point_spacing_px: 0.0,
        ..FetchLimits::default()
    };
    println!("{count} nodes; choosing, ms: median and longest of {VIEWS} views; nodes chosen");
    for (name, limits) in [("as by default", FetchLimits::default()), ("everything", everything)] {
        let (mut times, mut chosen, mut held) = (Vec::new(), 0, BTreeSet::new());
        for view in 0..VIEWS {
            let along = view as f64 / VIEWS as f64 - 0.5;
            let eye = DVec3::new(0.9 * length_m * along, 2.0, 1.7);
            let heading = 0.1 * view as f64;
            let view = View::look(eye, heading, 0.0, 1.05, UVec2::new(1024, 512));
            let request = ViewRequest { limits, ..ViewRequest::walking(view) };
            let started = Instant::now();
            let nodes = choose_nodes(&hierarchy, std::slice::from_ref(&source), &request, &held);
            times.push(started.elapsed().as_secs_f64() * 1e3);
            chosen = chosen.max(nodes.wanted.len());
            held = nodes.wanted.iter().map(|wanted| wanted.id).collect();
        }
        times.sort_by(f64::total_cmp);
        let (median, longest) = (times[VIEWS / 2], times[VIEWS - 1]);
        println!("{name:>14}: {median:.3}, {longest:.3}; {chosen}");
    }
}

fn street() -> PointSource {
    let half_size_m = 2048.0;
    PointSource {
        name: "drive".into(),
        point_count: 0,
        bounds: Bounds3 { min: DVec3::splat(-half_size_m), max: DVec3::splat(half_size_m) },
        cube: OctreeCube { centre: DVec3::ZERO, half_size_m, spacing_m: 40.0 },
        point_format: 7,
        record_length: 36,
        scale: DVec3::splat(0.001),
        offset: DVec3::ZERO,
        laszip_vlr: Vec::new(),
        extra_bytes_vlr: Vec::new(),
        gps_time: GpsTimeKind::Week,
    }
}

/// Every node within reach of the street, level by level until there are enough.
fn nodes(cube: &OctreeCube) -> Vec<HierarchyEntry> {
    let is_near = |key: &NodeKey| {
        let bounds = cube.node_bounds(*key);
        bounds.min.y <= 30.0 && bounds.max.y >= -30.0 && bounds.min.z <= 8.0 && bounds.max.z >= 0.0
    };
    let (mut entries, mut level) = (Vec::new(), vec![NodeKey::ROOT]);
    while entries.len() < NODES {
        entries.extend(level.iter().map(|&key| {
            HierarchyEntry::Node(Node { key, point_count: POINTS, byte_size: 8 * POINTS, crc32: 0 })
        }));
        level = level.iter().flat_map(NodeKey::children).filter(is_near).collect();
    }
    entries
}

use std::sync::Arc;

use flaneur_scene::{
    Bounds3, GpsTimeKind, MeshTile, MeshVertex, Node as StoredNode, NodeKey, OctreeCube,
    SceneUpdate, SurfaceClass, TileKey, TileLayer,
};
use glam::{DVec3, UVec2};
use proptest::prelude::*;

use super::*;
use crate::sight::Surfaces;

/// A cube of 128 m around the eye, which looks north.
fn source() -> PointSource {
    PointSource {
        name: "drive".into(),
        point_count: 0,
        bounds: Bounds3 { min: DVec3::splat(-64.0), max: DVec3::splat(64.0) },
        cube: OctreeCube { centre: DVec3::ZERO, half_size_m: 64.0, spacing_m: 2.0 },
        point_format: 7,
        record_length: 36,
        scale: DVec3::splat(0.001),
        offset: DVec3::ZERO,
        laszip_vlr: Vec::new(),
        extra_bytes_vlr: Vec::new(),
        gps_time: GpsTimeKind::Week,
    }
}

fn view() -> View {
    View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::new(640, 320))
}

/// A wall across the way, `ahead` metres from the eye.
fn wall(ahead: f64) -> Sight {
    let corner = |x: f32, z: f32| MeshVertex {
        position: [x, ahead as f32, z],
        normal: [0.0, -1.0, 0.0],
        uncertainty_m: 0.3,
        class: SurfaceClass::Wall,
    };
    let vertices = [(-60.0, -30.0), (60.0, -30.0), (60.0, 30.0), (-60.0, 30.0)];
    let mut surfaces = Surfaces::default();
    surfaces.note(&SceneUpdate::Mesh(Arc::new(MeshTile {
        key: TileKey { layer: TileLayer::Footprints, x: 0, y: 0 },
        origin: DVec3::ZERO,
        vertices: vertices.map(|(x, z)| corner(x, z)).to_vec(),
        indices: vec![0, 1, 2, 0, 2, 3],
    })));
    surfaces.sight(&view())
}

fn node(key: NodeKey, point_count: u32, byte_size: u32) -> WantedNode {
    let cube = source().cube;
    WantedNode {
        id: PointNodeId { source: 0, key },
        node: StoredNode { key, point_count, byte_size, crc32: 0 },
        distance_m: cube.node_bounds(key).centre().length(),
        spacing_m: cube.level_spacing_m(key.level),
        seen: true,
    }
}

fn gains(wanted: &[WantedNode], sight: &Sight, held: &BTreeSet<PointNodeId>) -> Vec<f64> {
    of_nodes(wanted, &[source()], held, &view(), sight, Some(5.0))
}

/// Cells of 16 m on the way north, the first at the eye's right hand.
fn northward(y: u32) -> NodeKey {
    NodeKey { level: 3, x: 4, y: 4 + y, z: 4 }
}

#[test]
fn what_mesh_hides_gains_least() {
    let wanted = [1, 2].map(|y| node(northward(y), 1_000_000, 100_000));
    let found = gains(&wanted, &wall(24.0), &BTreeSet::new());
    assert!(found[0] > 20.0 * found[1] && found[1] > 0.0, "{found:?}");
    // Without mesh, or with the wall behind both, either may show.
    for sight in [Surfaces::default().sight(&view()), wall(60.0)] {
        let found = gains(&wanted, &sight, &BTreeSet::new());
        assert!(found[1] > 0.05 * found[0], "{found:?}");
    }
}

#[test]
fn a_coarse_node_gains_little_where_its_finer_one_comes_first_or_is_held() {
    let above = northward(1).parent().expect("level 2");
    let wanted = [node(above, 1_000_000, 200_000), node(northward(1), 1_000_000, 50_000)];
    let held = BTreeSet::from([wanted[1].id]);
    let (alone, together) =
        (gains(&wanted[..1], &wall(24.0), &held), gains(&wanted, &wall(24.0), &BTreeSet::new()));
    assert!(together[1] > 0.0 && together[0] < alone[0], "{together:?} {alone:?}");
    let beside_held = gains(&wanted, &wall(24.0), &held);
    assert_eq!(beside_held, [together[0], 0.0], "what is held gains nothing more");
}

#[test]
fn without_photographs_what_covers_much_comes_first() {
    let sight = wall(24.0);
    let wanted = [node(NodeKey::ROOT, 1_000_000, 100_000), node(northward(1), 1_000_000, 100_000)];
    let held = BTreeSet::new();
    let found = of_nodes(&wanted, &[source()], &held, &view(), &sight, None);
    assert!(found[0] > found[1], "{found:?}");
}

fn key() -> impl Strategy<Value = NodeKey> {
    (0..5u32, 0..16u32, 8..16u32, 4..12u32).prop_map(|(level, x, y, z)| {
        let up = 4 - level;
        NodeKey { level, x: x >> up, y: y >> up, z: z >> up }
    })
}

proptest! {
    /// What is computed only when it is needed is what comes of computing every gain at every step.
    #[test]
    fn each_comes_when_it_gains_most_a_byte(
        nodes in prop::collection::btree_map(key(), (1..200_000u32, 1_000..400_000u32), 1..24),
        ahead in 10.0..60.0f64,
    ) {
        let wanted: Vec<WantedNode> =
            nodes.into_iter().map(|(key, (points, bytes))| node(key, points, bytes)).collect();
        let sight = wall(ahead);
        let found = gains(&wanted, &sight, &BTreeSet::new());
        let view = view();
        let sources = [source()];
        let all: Vec<Node> =
            wanted.iter().map(|wanted| Node::new(wanted, &sources, &view, &sight)).collect();
        let error = Error { view: &view, baseline_m: Some(5.0) };
        let mut course = Course::new(error, &sight);
        let mut left: Vec<usize> = (0..wanted.len()).collect();
        let mut last = f64::INFINITY;
        while !left.is_empty() {
            let rate = |&index: &usize| {
                course.gain(&all[index]) / f64::from(wanted[index].node.byte_size)
            };
            let place = (0..left.len())
                .max_by(|&a, &b| rate(&left[a]).total_cmp(&rate(&left[b])).then(left[b].cmp(&left[a])))
                .expect("some are left");
            let index = left[place];
            prop_assert!(rate(&index) <= last * (1.0 + 1e-12), "gains only fall");
            last = rate(&index);
            prop_assert_eq!(found[index], course.gain(&all[index]));
            course.take(&all[index]);
            left.remove(place);
        }
    }
}

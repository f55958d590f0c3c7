//! Odd distributions of points, and points that do not fit in memory.

use std::collections::BTreeMap;
use std::path::Path;

use flaneur_scene::NodeKey;
use glam::DVec3;
use proptest::prelude::*;

use super::Workplace;
use super::made::{MadeFile, Random, street};
use super::round_trip::assert_same_points;
use crate::ingest::points::tree::{LEAF_POINTS, LEAST_CHILD};
use crate::ingest::points::{StagedPoints, scan};

/// A budget that hundreds of thousands of points exceed.
const TINY_BUDGET: u64 = 4 << 20;

/// Points by node, after checking that each lies in its node's box and that the nodes form
/// a tree.
fn checked_nodes(staged: &StagedPoints) -> BTreeMap<NodeKey, usize> {
    let mut reader = las::CopcReader::from_path(&staged.file).unwrap();
    let entries: Vec<_> = reader.hierarchy_entries().collect();
    let mut nodes = BTreeMap::new();
    for entry in entries {
        let [level, x, y, z] = [entry.key.l, entry.key.x, entry.key.y, entry.key.z];
        let key = NodeKey { level: level as u32, x: x as u32, y: y as u32, z: z as u32 };
        let points = reader.read_entry(&entry).unwrap();
        assert_eq!(points.len() as i32, entry.point_count);
        let bounds = staged.source.cube.node_bounds(key);
        for point in points.points() {
            let point = point.unwrap();
            let distance = bounds.distance(DVec3::new(point.x, point.y, point.z));
            // Rounding of coordinates in the millions, twice.
            assert!(distance < 1e-8, "point {point:?} is {distance} m outside {key:?}");
        }
        assert_eq!(nodes.insert(key, points.len()), None, "{key:?} is listed twice");
    }
    for key in nodes.keys() {
        assert!(key.parent().is_none_or(|parent| nodes.contains_key(&parent)), "{key:?}");
    }
    nodes
}

fn assert_no_crumbs(nodes: &BTreeMap<NodeKey, usize>) {
    let has_children = |key: &NodeKey| key.children().iter().any(|c| nodes.contains_key(c));
    for (key, points) in nodes {
        if has_children(key) || *key == NodeKey::ROOT {
            continue;
        }
        assert!((LEAST_CHILD..=LEAF_POINTS).contains(points), "leaf {key:?} has {points} points");
    }
}

fn ingest(made: &MadeFile, memory: u64) -> (Workplace, StagedPoints) {
    let mut workplace = Workplace::new();
    workplace.job.memory = memory;
    let path = workplace.write("survey.laz", &made.laz(50_000));
    let staged = workplace.ingest(&[&path]).unwrap();
    assert_eq!(staged.len(), 1);
    assert_same_points(&[path], &staged[0], made.format < 6);
    let staged = staged.into_iter().next().unwrap();
    (workplace, staged)
}

#[test]
fn sorting_on_disk_gives_the_same_tree_as_in_memory() {
    let random = &mut Random(1);
    let raw = street(random, 600_000);
    let made = MadeFile::new(7, 0).with_points(random, raw);
    let (_in_memory, a) = ingest(&made, 1 << 30);
    let (_on_disk, b) = ingest(&made, TINY_BUDGET);
    let nodes = checked_nodes(&a);
    assert_no_crumbs(&nodes);
    assert!(nodes.len() > 10, "{} nodes", nodes.len());
    assert_eq!(nodes, checked_nodes(&b));
    assert_eq!(a.source, b.source);
    let stations =
        |staged: &StagedPoints| std::fs::read(staged.stations.as_ref().unwrap()).unwrap();
    assert!(!stations(&a).is_empty());
    assert_eq!(stations(&a), stations(&b));
}

#[test]
fn a_level_has_at_most_one_point_in_a_cell() {
    let random = &mut Random(2);
    let raw = street(random, 150_000);
    let (_workplace, staged) = ingest(&MadeFile::new(6, 0).with_points(random, raw), 1 << 30);
    let mut reader = las::CopcReader::from_path(&staged.file).unwrap();
    let root = reader.query(las::copc::LodSelection::Level(0), las::copc::BoundsSelection::All);
    let cube = &staged.source.cube;
    let corner = cube.centre - cube.half_size_m;
    let mut cells: Vec<_> = root
        .unwrap()
        .points()
        .map(|point| {
            let point = point.unwrap();
            ((DVec3::new(point.x, point.y, point.z) - corner) / cube.spacing_m).floor().as_ivec3()
        })
        .map(|cell| cell.to_array())
        .collect();
    let points = cells.len();
    cells.sort_unstable();
    cells.dedup();
    // The root also keeps children that would be tiny; here there are none.
    assert_eq!(cells.len(), points);
    assert!(points > 1_000, "{points} points at the root");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let random = &mut Random(3);
    let raw = street(random, 300_000);
    let laz = MadeFile::new(7, 3).with_points(random, raw).laz(50_000);
    for memory in [1 << 30, TINY_BUDGET] {
        let files = [1, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut workplace = Workplace::new();
            workplace.job.memory = memory;
            let path = workplace.write("survey.laz", &laz);
            let staged = pool.install(|| workplace.ingest(&[&path])).unwrap();
            std::fs::read(&staged[0].file).unwrap()
        });
        assert!(files[0] == files[1], "the files differ with a budget of {memory}");
    }
}

#[test]
fn clusters_too_dense_for_the_first_grid_are_divided_again() {
    let random = &mut Random(4);
    let mut cluster = |centre: i32| -> Vec<[i32; 3]> {
        (0..270_000).map(|_| [0; 3].map(|_| centre + random.below(2_000) as i32)).collect()
    };
    // Two metres across and 4 000 km apart: where one corner of a bounding box is a mistake.
    let mut raw = cluster(-2_000_000_000);
    raw.extend(cluster(2_000_000_000));
    let made = MadeFile::new(6, 0).with_points(random, raw);
    let (_in_memory, a) = ingest(&made, 1 << 30);
    let (_on_disk, b) = ingest(&made, TINY_BUDGET);
    for staged in [a, b] {
        let nodes = checked_nodes(&staged);
        let deepest = nodes.keys().map(|key| key.level).max().unwrap();
        assert!((20..=25).contains(&deepest), "deepest level {deepest}");
    }
}

#[test]
fn points_in_one_place_stay_together() {
    let random = &mut Random(5);
    let made = MadeFile::new(1, 0).with_points(random, (0..270_000).map(|_| [5, 6, 7]));
    for memory in [1 << 30, TINY_BUDGET] {
        let (_workplace, staged) = ingest(&made, memory);
        assert!(checked_nodes(&staged).len() <= 26);
    }
}

#[test]
fn scanning_sees_every_point() {
    let random = &mut Random(6);
    let raw = street(random, 120_000);
    let made = MadeFile::new(3, 0).with_points(random, raw);
    let workplace = Workplace::new();
    let path = workplace.write("survey.laz", &made.laz(10_000));
    let staged = workplace.ingest(&[&path]).unwrap();
    let columns = |path: &Path| {
        let mut points = Vec::new();
        scan(&[path.to_owned()], &workplace.job, |batch| {
            for (i, position) in batch.positions.iter().enumerate() {
                let returns = (batch.return_numbers[i], batch.return_counts[i]);
                points.push((position.to_array().map(f64::to_bits), batch.classes[i], returns));
            }
            Ok(())
        })
        .unwrap();
        points
    };
    let mut expected: Vec<_> = made
        .records
        .iter()
        .map(|record| {
            let position: [u64; 3] = std::array::from_fn(|axis| {
                let raw = i32::from_le_bytes(record[4 * axis..][..4].try_into().unwrap());
                (f64::from(raw) * made.scale[axis] + made.offset[axis]).to_bits()
            });
            (position, record[15] & 31, (record[14] & 7, record[14] >> 3 & 7))
        })
        .collect();
    assert_eq!(columns(&path), expected, "in the order of the file");
    let mut found = columns(&staged[0].file);
    // Class 12 became a flag.
    expected.iter_mut().filter(|point| point.1 == 12).for_each(|point| point.1 = 1);
    expected.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, expected);
}

/// Distributions that trouble trees: one place, a line, a plane, far clusters, anything.
fn distribution() -> impl Strategy<Value = Vec<[i32; 3]>> {
    let any_point = || prop_oneof![any::<[i32; 3]>(), Just([i32::MIN; 3]), Just([i32::MAX; 3])];
    let near = |centre: [i32; 3], i: i32| centre.map(|axis| axis.saturating_add(i % 100));
    prop_oneof![
        (any_point(), 1..40_000usize).prop_map(|(point, n)| vec![point; n]),
        (any_point(), any_point(), 2..40_000i64).prop_map(|(a, b, n)| {
            let between = |a: i32, b: i32, i| i64::from(a) + (i64::from(b) - i64::from(a)) * i / n;
            (0..n)
                .map(|i| std::array::from_fn(|axis| between(a[axis], b[axis], i) as i32))
                .collect()
        }),
        (any_point(), any_point(), 1..40_000i32).prop_map(move |(a, b, n)| {
            (0..n).map(|i| near(if i % 3 == 0 { a } else { b }, i)).collect()
        }),
        proptest::collection::vec(any_point(), 1..2_000),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn odd_distributions_are_kept(raw in distribution(), seed: u64, format in 0u8..=8) {
        prop_assume!(![4, 5].contains(&format));
        let made = MadeFile::new(format, 0).with_points(&mut Random(seed), raw);
        for memory in [1 << 30, 1 << 20] {
            let (_workplace, staged) = ingest(&made, memory);
            checked_nodes(&staged);
        }
    }
}

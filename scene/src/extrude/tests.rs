use std::collections::HashMap;

use proptest::prelude::*;

use super::*;

const KEY: TileKey = TileKey { layer: TileLayer::Footprints, x: 0, y: 0 };

/// An L of 3 × 3 m without its north-east corner, and a courtyard in its thick part.
fn outline() -> (Vec<DVec2>, Vec<DVec2>) {
    let outer = [(0., 0.), (30., 0.), (30., 15.), (15., 15.), (15., 30.), (0., 30.)];
    let hole = [(4., 4.), (8., 5.), (7., 9.)];
    (outer.map(DVec2::from).to_vec(), hole.map(DVec2::from).to_vec())
}

const OUTLINE_AREA: f64 = 675.0 - 8.5;

/// The outline moved to `origin`, wound as asked.
fn building(origin: DVec2, flip_outer: bool, flip_hole: bool) -> Footprint {
    let (mut outer, mut hole) = outline();
    if flip_outer {
        outer.reverse();
    }
    if flip_hole {
        hole.reverse();
    }
    let rings = [outer, hole].map(|ring| ring.iter().map(|p| *p + origin).collect());
    footprint(rings.to_vec(), 12.5)
}

fn footprint(rings: Vec<Vec<DVec2>>, height_m: f64) -> Footprint {
    Footprint {
        id: "b".to_owned(),
        polygons: vec![Polygon { rings }],
        base_m: 40.0,
        height_m,
        uncertainty_m: 0.5,
        attributes: "{}".to_owned(),
    }
}

fn corners(tile: &MeshTile) -> impl Iterator<Item = [&MeshVertex; 3]> {
    tile.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| &tile.vertices[i as usize]))
}

fn position(vertex: &MeshVertex) -> DVec3 {
    DVec3::from_array(vertex.position.map(f64::from))
}

/// Whether `p`, relative to the tile's origin, is inside of the outline.
fn inside(p: DVec2) -> bool {
    let (outer, hole) = outline();
    let within = |ring: &[DVec2]| {
        let crossed = |(a, b): (&DVec2, &DVec2)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        ring.iter().zip(ring.iter().cycle().skip(1)).filter(|edge| crossed(*edge)).count() % 2 == 1
    };
    within(&outer) && !within(&hole)
}

/// The area of the roof in square metres.
fn roof_area(tile: &MeshTile) -> f64 {
    corners(tile)
        .filter(|t| t[0].class == SurfaceClass::Roof)
        .map(|t| t.map(position))
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .sum()
}

#[test]
fn normals_point_outwards_whatever_the_winding() {
    for (flip_outer, flip_hole) in [(false, false), (false, true), (true, false), (true, true)] {
        let tile = extrude_footprints(
            KEY,
            DVec3::new(0.0, 0.0, 40.0),
            &[building(DVec2::ZERO, flip_outer, flip_hole)],
            2.0,
        );
        let walls = corners(&tile).filter(|t| t[0].class == SurfaceClass::Wall).count();
        assert_eq!(walls, 2 * (6 + 3), "two triangles a wall");
        for triangle in corners(&tile) {
            let [a, b, c] = triangle.map(position);
            let normal = DVec3::from_array(triangle[0].normal.map(f64::from));
            let geometric = (b - a).cross(c - a).normalize();
            assert!(geometric.distance(normal) < 1e-6, "the winding agrees with the normal");
            let middle = ((a + b + c) / 3.0).truncate();
            match triangle[0].class {
                SurfaceClass::Roof => {
                    assert_eq!(normal, DVec3::Z);
                    assert!(inside(middle), "a roof triangle at {middle}");
                }
                _ => {
                    let step = normal.truncate() * 1e-3;
                    let sides = (inside(middle + step), inside(middle - step));
                    assert_eq!(sides, (false, true), "{flip_outer} {flip_hole} at {middle}");
                }
            }
        }
    }
}

#[test]
fn a_prism_is_closed_but_for_its_foot() {
    let tile = extrude_footprints(
        KEY,
        DVec3::new(0.0, 0.0, 40.0),
        &[building(DVec2::ZERO, true, false)],
        1.0,
    );
    // Every edge is run through once in each direction, but those of the foot.
    let mut edges: HashMap<([u32; 3], [u32; 3]), i32> = HashMap::new();
    let key = |v: &MeshVertex| v.position.map(f32::to_bits);
    for t in corners(&tile) {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *edges.entry((key(a), key(b))).or_default() += 1;
        }
    }
    for ((a, b), count) in &edges {
        assert_eq!(*count, 1, "an edge is used twice in one direction");
        let height = |p: &[u32; 3]| f32::from_bits(p[2]);
        let at_foot = height(a) == -1.0 && height(b) == -1.0;
        assert_eq!(edges.contains_key(&(*b, *a)), !at_foot, "an edge at {}", height(a));
    }
}

#[test]
fn areas_survive_far_coordinates() {
    for origin in [
        DVec2::ZERO,
        DVec2::new(651_143.297_675_11, 6_861_442.905_745_622),
        DVec2::splat(-1e8),
        DVec2::new(1e8, 1e8),
    ] {
        let footprint = building(origin, false, true);
        let tile = extrude_footprints(KEY, origin.extend(40.0), &[footprint], 0.0);
        let area = roof_area(&tile);
        // Coordinates near 1e8 are multiples of 1.5e-8 m, and f32 within 30 m of 1.9e-6 m: over
        // a perimeter of 130 m that is at most 3e-4 m².
        assert!((area - OUTLINE_AREA).abs() < 3e-4, "{area} m² at {origin}");
        for [a, ..] in corners(&tile) {
            assert!(position(a).z == 0.0 || position(a).z == 12.5);
        }
    }
}

#[test]
fn many_holes_leave_exactly_their_area() {
    // A grid of courtyards, of which pairs touch at a corner; turned, so that no edge is level.
    let square = |x: f64, y: f64, side: f64| {
        [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]
            .map(|p| DVec2::from_angle(0.3).rotate(DVec2::from(p)))
            .to_vec()
    };
    for touching in [false, true] {
        let mut rings = vec![square(0.0, 0.0, 100.0)];
        let mut area = 1e4;
        for i in 0..7 {
            for j in 0..7 {
                let paired = i % 3 == j % 3 && i % 3 < 2;
                if touching && !paired {
                    continue;
                }
                let side = if touching { 13.0 } else { 6.0 };
                rings.push(square(3.0 + 13.0 * f64::from(i), 4.0 + 13.0 * f64::from(j), side));
                area -= side * side;
            }
        }
        let origin = DVec3::new(0.0, 0.0, 40.0);
        let tile = extrude_footprints(KEY, origin, &[footprint(rings, 5.0)], 0.0);
        // Some hundred triangles of up to 100 m, with corners within 4e-6 m.
        let found = roof_area(&tile);
        assert!((found - area).abs() < 0.02, "{found} m², not {area}: touching {touching}");
    }
}

/// Rings that once made the triangulation of a roof run forever: a hole that is not inside, and
/// holes that cross.
#[test]
fn tangled_holes_end() {
    let ring = |points: &[(f64, f64)]| points.iter().copied().map(DVec2::from).collect();
    let outside = vec![
        ring(&[(3., 1.), (1., 0.), (1., 4.), (4., 1.), (1., 1.)]),
        ring(&[(0., 4.), (0., 2.), (1., 2.)]),
        ring(&[(2., 2.), (0., 0.), (4., 0.), (3., 3.), (1., 4.), (4., 1.)]),
    ];
    let crossing = vec![
        ring(&[(4., 0.), (1., 3.), (1., 4.), (0., 3.), (4., 3.)]),
        ring(&[(2., 1.), (3., 0.), (2., 0.), (3., 0.), (3., 2.)]),
        ring(&[(3., 2.), (0., 0.), (0., 1.), (0., 0.), (3., 3.), (2., 3.)]),
    ];
    for rings in [outside, crossing] {
        let tile = extrude_footprints(KEY, DVec3::ZERO, &[footprint(rings, 5.0)], 0.0);
        assert!(!tile.indices.is_empty());
    }
}

#[test]
fn neighbours_that_share_a_wall_each_have_theirs() {
    let square = |x: f64| {
        vec![[(x, 0.0), (x + 10.0, 0.0), (x + 10.0, 10.0), (x, 10.0)].map(DVec2::from).to_vec()]
    };
    let row = [footprint(square(0.0), 9.0), footprint(square(10.0), 6.0)];
    let tile = extrude_footprints(KEY, DVec3::new(0.0, 0.0, 40.0), &row, 0.0);
    assert_eq!(roof_area(&tile), 200.0);
    let mut shared = [0, 0];
    for t in corners(&tile).filter(|t| t.iter().all(|v| v.position[0] == 10.0)) {
        shared[usize::from(t[0].normal[0] > 0.0)] += 1;
    }
    assert_eq!(shared, [2, 2], "two triangles on either side of the common wall");
}

#[test]
fn without_height_there_is_a_slab_and_without_area_nothing() {
    let (outer, hole) = outline();
    let flat = footprint(vec![outer.clone(), hole], 0.0);
    let tile = extrude_footprints(KEY, DVec3::new(0.0, 0.0, 40.0), &[flat], 0.0);
    assert!((roof_area(&tile) - OUTLINE_AREA).abs() < 1e-4);
    assert!(tile.vertices.iter().all(|v| v.class == SurfaceClass::Roof && v.position[2] == 0.0));

    let p = DVec2::new(3.0, 4.0);
    let degenerate = [
        vec![],
        vec![vec![]],
        vec![vec![p]],
        vec![vec![p, p, p]],
        vec![vec![p, 2.0 * p]],
        vec![vec![p, 2.0 * p, 3.0 * p]],
        vec![vec![DVec2::ZERO, DVec2::X, DVec2::NAN]],
        vec![vec![DVec2::ZERO, DVec2::X, DVec2::splat(f64::INFINITY)]],
    ];
    for rings in degenerate {
        let tile = extrude_footprints(KEY, DVec3::ZERO, &[footprint(rings.clone(), 5.0)], 1.0);
        assert!(tile.indices.is_empty(), "{rings:?}");
    }
    let tile = extrude_footprints(KEY, DVec3::ZERO, &[footprint(vec![outer], f64::NAN)], 1.0);
    assert!(tile.indices.is_empty(), "a height that is no number");
}

#[test]
fn ground_looks_up_and_leaves_holes_where_it_is_unknown() {
    let mut tile = GroundTile {
        index: (3, -2),
        origin: DVec2::new(651_000.0, 6_861_000.0),
        spacing_m: 2.0,
        columns: 4,
        heights: (0..12u8).map(|i| 40.0 + f32::from(i % 4) * 0.5).collect(),
        uncertainty_m: 0.1,
    };
    let mesh = triangulate_ground(&tile);
    assert_eq!(mesh.indices.len(), 3 * 2 * 6);
    assert_eq!((mesh.key.x, mesh.key.y), (3, -2));
    let plan: f64 =
        corners(&mesh).map(|t| t.map(position)).map(|[a, b, c]| (b - a).cross(c - a).z / 2.0).sum();
    assert!((plan - 24.0).abs() < 1e-6, "3 × 2 cells of 4 m²: {plan}");
    assert!(mesh.vertices.iter().all(|v| v.normal[2] > 0.9));
    tile.heights[5] = f32::NAN;
    assert_eq!(triangulate_ground(&tile).indices.len(), 3 * 2 * 2, "a node belongs to four cells");
    tile.heights.clear();
    assert!(triangulate_ground(&tile).indices.is_empty());
}

proptest! {
    /// Rings of any shape, small whole coordinates so that points and edges coincide: no panic,
    /// whole triangles, unit normals.
    #[test]
    fn any_ring_gives_triangles_or_nothing(
        rings in prop::collection::vec(
            prop::collection::vec((0..5i8, 0..5i8), 0..9), 0..4),
        height in prop_oneof![Just(0.0), 0.1..50.0, Just(-3.0)],
    ) {
        let ring = |ring: Vec<(i8, i8)>| {
            ring.into_iter().map(|(x, y)| DVec2::new(f64::from(x), f64::from(y))).collect()
        };
        let footprint = footprint(rings.into_iter().map(ring).collect(), height);
        let tile = extrude_footprints(KEY, DVec3::ZERO, &[footprint], 0.5);
        prop_assert_eq!(tile.indices.len() % 3, 0);
        for triangle in corners(&tile) {
            let normal = DVec3::from_array(triangle[0].normal.map(f64::from));
            prop_assert!((normal.length() - 1.0).abs() < 1e-6);
        }
    }
}

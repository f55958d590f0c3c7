use flaneur_scene::{MeshVertex, SurfaceClass, TileLayer};
use glam::DVec3;
use proptest::prelude::*;

use super::*;

/// Triangles far from the world's origin.
fn tile(x: i32, origin: DVec3, triangles: &[[DVec3; 3]]) -> SceneUpdate {
    let vertex = |p: &DVec3| MeshVertex {
        position: p.as_vec3().to_array(),
        normal: [0.0, 0.0, 1.0],
        uncertainty_m: 0.1,
        class: SurfaceClass::Wall,
    };
    let vertices: Vec<MeshVertex> = triangles.iter().flatten().map(vertex).collect();
    let indices = (0..vertices.len() as u32).collect();
    let key = TileKey { layer: TileLayer::Footprints, x, y: 0 };
    SceneUpdate::Mesh(Arc::new(MeshTile { key, origin, vertices, indices }))
}

/// A wall across the way to the north, `ahead` metres from the origin.
fn wall(ahead: f64, [left, right]: [f64; 2]) -> [[DVec3; 3]; 2] {
    let [a, b] = [left, right].map(|x| DVec3::new(x, ahead, -30.0));
    let [c, d] = [left, right].map(|x| DVec3::new(x, ahead, 30.0));
    [[a, b, c], [b, c, d]]
}

const EYE: DVec3 = DVec3::new(652_000.0, 6_861_000.0, 40.0);

fn north() -> View {
    View::look(EYE, 0.0, 0.0, 1.0, UVec2::new(480, 240))
}

fn ball(at: DVec3, radius: f64) -> Bounds3 {
    Bounds3 { min: EYE + at - radius, max: EYE + at + radius }
}

#[test]
fn what_stands_behind_a_wall_does_not_show() {
    let mut surfaces = Surfaces::default();
    let blind = surfaces.sight(&north());
    assert!(blind.is_blind());
    let behind = ball(DVec3::new(0.0, 40.0, 0.0), 5.0);
    let before = ball(DVec3::new(0.0, 10.0, 0.0), 2.0);
    let count = |sight: &Sight, bounds| sight.through(bounds).count();
    assert!(count(&blind, behind) > 2);
    surfaces.note(&tile(0, EYE, &wall(20.0, [-60.0, 60.0])));
    let sight = surfaces.sight(&north());
    assert!(!sight.is_blind());
    assert_eq!(count(&sight, behind), 0);
    assert_eq!(count(&sight, before), count(&blind, before));
    assert!(sight.through(before).all(|(_, _, is_surface)| !is_surface));
    // A front that stands out a little from what a footprint says.
    let front = ball(DVec3::new(0.0, 22.0, 0.0), 1.5);
    assert!(count(&sight, front) > 0 && sight.through(front).all(|(_, _, is_surface)| is_surface));
    // A nearer wall hides the left half.
    surfaces.note(&tile(1, EYE, &wall(8.0, [-60.0, 0.0])));
    let depths: Vec<f64> =
        surfaces.sight(&north()).rays().iter().filter_map(|(_, depth)| *depth).collect();
    assert!(
        depths.iter().all(|&d| (d - 8.0).abs() < 1e-6 || (d - 20.0).abs() < 1e-6),
        "{depths:?}"
    );
    assert_eq!(depths.iter().filter(|&&d| d < 10.0).count(), depths.len() / 2);
    surfaces.note(&SceneUpdate::DropMesh(TileKey { layer: TileLayer::Footprints, x: 1, y: 0 }));
    surfaces.note(&SceneUpdate::DropMesh(TileKey { layer: TileLayer::Footprints, x: 0, y: 0 }));
    assert!(surfaces.sight(&north()).is_blind());
}

#[test]
fn corners_that_are_no_places_are_left_out() {
    let nowhere = DVec3::new(f64::NAN, 1.0, f64::INFINITY);
    let mut surfaces = Surfaces::default();
    surfaces.note(&tile(0, EYE, &[[nowhere, DVec3::Y, DVec3::Z]]));
    assert!(surfaces.sight(&north()).is_blind());
    let far = DVec3::new(1e30, -1e30, 5.0);
    let mut triangles = wall(20.0, [-60.0, 60.0]).to_vec();
    triangles.push([far, -far, DVec3::new(0.0, 50.0, 0.0)]);
    surfaces.note(&tile(0, EYE, &triangles));
    assert!(!surfaces.sight(&north()).is_blind());
}

fn place() -> impl Strategy<Value = DVec3> {
    (-80.0..80.0, -80.0..80.0, -10.0..30.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

proptest! {
    /// The grid finds what trying every triangle finds, the plane equation being solved another way.
    #[test]
    fn a_ray_meets_the_first_of_all_triangles(
        triangles in prop::collection::vec((place(), place(), place()), 1..40),
        eye in place(), heading in 0.0..std::f64::consts::TAU, pitch in -1.4..1.4f64,
    ) {
        let triangles: Vec<[DVec3; 3]> = triangles
            .into_iter()
            .map(|(a, b, c)| [a, a + (b - a) * 0.3, a + (c - a) * 0.3].map(|p| p.as_vec3().as_dvec3()))
            .collect();
        let mut surfaces = Surfaces::default();
        surfaces.note(&tile(0, EYE, &triangles));
        let view = View::look(EYE + eye, heading, pitch, 1.2, UVec2::new(48, 24));
        let sight = surfaces.sight(&view);
        for (ray, found) in sight.rays() {
            let origin = ray.origin - EYE;
            let met = triangles.iter().filter_map(|[a, b, c]| {
                let normal = (b - a).cross(c - a);
                let depth = normal.dot(a - origin) / normal.dot(ray.direction);
                let p = origin + ray.direction * depth;
                let inside = |from: &DVec3, to: &DVec3| (to - from).cross(p - from).dot(normal);
                let least = inside(a, b).min(inside(b, c)).min(inside(c, a));
                // On an edge rounding decides.
                let on_edge = least.abs() < 1e-6 * normal.length_squared();
                (depth >= 0.0 && least >= 0.0).then_some((depth, on_edge))
            });
            let nearest = met.min_by(|a, b| a.0.total_cmp(&b.0));
            match (nearest, found) {
                (Some((depth, false)), Some(found)) => {
                    prop_assert!((depth - found).abs() < 1e-5 * (1.0 + depth), "{depth} {found}");
                }
                (Some((depth, false)), None) => prop_assert!(false, "none, but {depth}"),
                (None, Some(found)) => {
                    let p = origin + ray.direction * *found;
                    let near = triangles.iter().any(|[a, b, c]| {
                        let normal = (b - a).cross(c - a).normalize_or_zero();
                        normal.dot(p - a).abs() < 1e-4
                    });
                    prop_assert!(near, "{found}, but nothing is there");
                }
                (Some((_, true)), _) | (None, None) => {}
            }
        }
    }
}

//! The depth test on the device against its reference.

use glam::DVec3;

use super::reference::{
    Occluders, Place, depth_bias, depth_on_texel_ray, relief_depth, visibility,
};
use crate::kernel_tests::run;
use crate::tolerances::{DEPTH_M, DEPTH_TEST_RELATIVE, VISIBILITY};

const KERNEL: &str = "
struct Query {
    c: vec3<f32>,
    relief_m: f32,
    n: vec3<f32>,
    texel_m: f32,
    ray: vec3<f32>,
    point: f32,
    mesh: vec2<f32>,
    is_point: u32,
    pose_m: f32,
}

@group(0) @binding(0) var<storage, read> queries: array<Query>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec2<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&queries) {
        let q = queries[id.x];
        let across = vec4(1.0 / dot(q.n, q.ray));
        let z = depths_on_texel_rays(q.c, q.n, across);
        let relief = relief_depths(q.relief_m, across);
        let bias = depth_bias(q.texel_m, q.pose_m, q.n, q.ray);
        let behind = q.mesh.x + select(0.0, q.mesh.y, q.is_point == 1u);
        let seen = visibilities(z, bias, relief, Occluders(vec4(behind), vec4(q.point)));
        answers[id.x] = vec2(z.y, seen.y);
    }
}";

#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Query {
    c: [f32; 3],
    relief_m: f32,
    n: [f32; 3],
    texel_m: f32,
    ray: [f32; 3],
    point: f32,
    mesh: [f32; 2],
    is_point: u32,
    pose_m: f32,
}

/// Places around occluders at their depth, with planes from facing to grazing and beyond.
fn queries() -> Vec<Query> {
    let mut queries = Vec::new();
    for i in 0..4000u32 {
        // Low-discrepancy sequences: every combination of offsets and angles occurs.
        let sequence = |step: f64| ((f64::from(i) + 0.5) * step).fract() as f32;
        let z = 2.0 + 60.0 * sequence(0.618_034);
        let angle = 1.7 * sequence(0.754_878);
        let m = [sequence(0.569_840) - 0.5, sequence(0.324_718) - 0.5];
        let texel = 1.0 / 256.0;
        let offset = |span: f32, step: f64| span * (2.0 * sequence(step) - 1.0);
        queries.push(Query {
            c: [m[0] * z, m[1] * z, z],
            relief_m: if i % 3 == 0 { 0.0 } else { 0.5 * sequence(0.438_579) },
            n: [angle.sin(), 0.0, -angle.cos()],
            texel_m: z * texel,
            ray: [m[0] + texel * offset(0.5, 0.271_2), m[1] + texel * offset(0.5, 0.913), 1.0],
            point: if i % 5 == 0 { 1e30 } else { z + offset(1.0, 0.377_7) },
            mesh: [if i % 7 == 0 { 1e30 } else { z + offset(1.0, 0.829) }, 0.4],
            is_point: i % 2,
            pose_m: if i % 4 == 0 { 0.0 } else { 0.3 * sequence(0.637_2) },
        });
    }
    queries
}

fn wide(v: [f32; 3]) -> DVec3 {
    glam::Vec3::from_array(v).as_dvec3()
}

#[test]
fn device_and_reference_agree() {
    let queries = queries();
    let answers: Vec<[f32; 2]> = run(
        &[super::WGSL, KERNEL].concat(),
        &[bytemuck::cast_slice(&queries)],
        queries.len(),
        queries.len(),
    );
    let (mut seen, mut undecided, mut hidden) = (0, 0, 0);
    for (query, answer) in queries.iter().zip(answers) {
        let z = depth_on_texel_ray(wide(query.c), wide(query.n), wide(query.ray));
        assert!((z - f64::from(answer[0])).abs() < DEPTH_M, "{z} {answer:?} {query:?}");
        let place = if query.is_point == 1 { Place::Point } else { Place::Mesh };
        let relief = relief_depth(f64::from(query.relief_m), wide(query.n), wide(query.ray));
        let occluders = Occluders {
            mesh_m: f64::from(query.mesh[0]),
            mesh_uncertainty_m: f64::from(query.mesh[1]),
            point_m: f64::from(query.point),
        };
        let (texel_m, pose_m) = (f64::from(query.texel_m), f64::from(query.pose_m));
        let bias = depth_bias(texel_m, pose_m, wide(query.n), wide(query.ray));
        let visible = |share: f64| visibility(z * (1.0 + share), bias, place, relief, occluders);
        let (nearer, farther) = (visible(-DEPTH_TEST_RELATIVE), visible(DEPTH_TEST_RELATIVE));
        let found = f64::from(answer[1]);
        assert!(
            farther - VISIBILITY <= found && found <= nearer + VISIBILITY,
            "{answer:?} {query:?}"
        );
        seen += u32::from(found == 1.0);
        undecided += u32::from(found > 0.0 && found < 1.0);
        hidden += u32::from(found == 0.0);
    }
    assert!(seen > 500 && hidden > 500 && undecided > 100, "{seen} {hidden} {undecided}");
}

#[test]
fn the_hybrid_rule_holds_in_depth_maps() {
    let wall = |point_m| Occluders { mesh_m: 10.0, mesh_uncertainty_m: 0.5, point_m };
    // A lidar point behind the wall's plane, within its uncertainty, is the wall.
    assert_eq!(visibility(10.4, 0.01, Place::Point, 0.0, wall(10.4)), 1.0);
    assert!(visibility(10.6, 0.01, Place::Point, 0.0, wall(10.6)) < 1e-3);
    // The wall's mesh is seen although its points lie before it, but not behind a car.
    assert_eq!(visibility(10.0, 0.01, Place::Mesh, 0.5, wall(9.6)), 1.0);
    assert!(visibility(10.0, 0.01, Place::Mesh, 0.5, wall(7.0)) < 1e-3);
    // Mesh behind mesh is hidden, however uncertain both are.
    assert!(visibility(10.3, 0.01, Place::Mesh, 0.5, wall(1e30)) < 1e-3);
}

#[test]
fn a_road_at_a_grazing_angle_does_not_hide_itself() {
    // 1.7 m above the road, looking 12 m ahead: 8°. A disc of 8 cm that faces the camera hides
    // what lies up to 0.57 m behind it on the road.
    let (n, ray) = (DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, 1.7 / 12.0, 1.0));
    let road = Occluders { mesh_m: 1e30, mesh_uncertainty_m: 0.0, point_m: 11.43 };
    assert!(visibility(12.0, 0.02, Place::Point, 0.0, road) < 1e-3);
    assert_eq!(visibility(12.0, 0.02, Place::Point, relief_depth(0.1, n, ray), road), 1.0);
    // A kerb 30 cm high does hide it.
    let kerb = Occluders { point_m: 12.0 - 0.3 / (1.7 / 12.0), ..road };
    assert!(visibility(12.0, 0.02, Place::Point, relief_depth(0.1, n, ray), kerb) < 1e-3);
}

#[test]
fn an_uncertain_pose_leaves_more_room_the_more_a_surface_is_inclined() {
    let ray = DVec3::Z;
    let inclined = |degrees: f64| {
        let angle = degrees.to_radians();
        depth_bias(0.02, 0.1, DVec3::new(angle.sin(), 0.0, -angle.cos()), ray)
    };
    assert!((inclined(0.0) - 0.12).abs() < 1e-12, "{}", inclined(0.0));
    assert!((inclined(45.0) - 0.22).abs() < 1e-12, "{}", inclined(45.0));
    // Edge-on it stays finite.
    assert!((inclined(90.0) - 1.12).abs() < 1e-12, "{}", inclined(90.0));
    assert_eq!(depth_bias(0.02, 0.0, DVec3::X, ray), 0.02);
}

#[test]
fn what_other_drives_put_a_little_before_a_place_hides_it_only_beside_a_better_view() {
    let seen = |point_m| {
        let occluders = Occluders { mesh_m: 1e30, mesh_uncertainty_m: 0.0, point_m };
        visibility(10.0, 0.01, Place::Point, 0.0, occluders)
    };
    assert_eq!(seen(9.97), 1.0);
    let undecided = seen(9.76);
    assert!(undecided > 0.0 && undecided < 1e-4 && seen(9.86) > undecided, "{undecided}");
    assert_eq!(seen(9.5), 0.0);
}

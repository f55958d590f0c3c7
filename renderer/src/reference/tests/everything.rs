//! Frames with all that there is: exposure gains, alignment, and what is inferred.

use flaneur_scene::{ImageUpdate, PosedCamera, SceneUpdate, View};
use glam::{DVec3, UVec2};

use super::common::{Street, block, camera, image_update, mesh_update, points_update};
use super::gains::exposed;
use super::{SIZE, both, keep_both};
use crate::tolerances::FRAME_ALIKE_SHARE;
use crate::{Mode, Settings, Surface};

/// A street with a wall, whose farther half is in the photographs alone, and a kerb of points before
/// it; the photographs are differently exposed, and said to be some centimetres beside their places.
fn updates(origin: DVec3) -> Vec<SceneUpdate> {
    let street = Street::with_pole(origin);
    let wall = block([6.0, -20.0, 0.0], [10.0, 0.0, 9.0]);
    let missing = block([6.0, 0.0, 0.0], [10.0, 20.0, 9.0]);
    let kerb = block([4.0, -20.0, 0.0], [4.3, 20.0, 0.4]);
    let street = Street { blocks: vec![wall, missing, kerb], ..street };
    let taken = |id: &str, at: [f64; 3], heading: f64, off: DVec3, by: [f64; 3]| {
        let camera = camera(origin, at, heading, 8.0, 80.0, UVec2::new(480, 360));
        let image = street.photograph(id, camera);
        let camera = PosedCamera { centre: camera.centre + off, ..camera };
        image_update(exposed(ImageUpdate { camera, ..image }, by))
    };
    let off = DVec3::new(0.01, 0.04, -0.02);
    vec![
        mesh_update(street.mesh(&[0, 3], 0.05)),
        points_update(street.points(&[2], 0.05)),
        taken("a/east", [-1.0, -0.9, 1.9], 85.0, off, [0.9, 0.95, 1.0]),
        taken("a/north", [-1.0, -0.8, 1.9], 20.0, off, [0.9, 0.95, 1.0]),
        taken("b/east", [-0.9, 1.9, 2.0], 95.0, -off, [0.7, 0.7, 0.65]),
        taken("c/east", [-0.5, 5.0, 2.2], 110.0, DVec3::ZERO, [1.0, 0.95, 0.9]),
    ]
}

#[test]
fn frames_with_everything() {
    for origin in [DVec3::ZERO, DVec3::new(651_187.3, 6_861_353.6, 42.8), DVec3::splat(1e8)] {
        let view = View::from(camera(origin, [-0.8, 0.5, 1.8], 88.0, 8.0, 60.0, SIZE));
        let (frame, _, reference) =
            both(&updates(origin), &view, Mode::Hybrid, Settings::default());
        keep_both(&frame, &reference, "everything");
        let difference = reference.difference(&frame);
        let of = |surface| reference.pixels.iter().filter(|p| p.surface == surface).count();
        let kinds = [Surface::MeshColoured, Surface::PointColoured, Surface::Inferred].map(of);
        println!("{kinds:?} of mesh, of points and inferred, {difference:?}");
        assert!(kinds.iter().all(|&pixels| pixels > 500), "{kinds:?}");
        assert!(difference.compared > 25_000, "{difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
        assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{difference:?}");
    }
}

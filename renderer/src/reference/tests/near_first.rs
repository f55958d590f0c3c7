//! Points that were taken from several places, in views and in depth maps, against f64.

use std::sync::Arc;

use flaneur_scene::{PointChunk, PointStations, SceneUpdate, View};
use glam::{DVec3, UVec2};

use super::common::{Street, camera, image_update, mesh_update, points_update};
use super::{SIZE, assert_in_place, both, settings};
use crate::reference::difference::STEP_M;
use crate::tolerances::FRAME_ALIKE_SHARE;
use crate::{Mode, Settings};

/// The street's wall and pole as two drives have them, one 12 cm further to the west than the
/// other, each taken from places along the street.
fn updates(origin: DVec3) -> Vec<SceneUpdate> {
    let street = Street::with_pole(origin);
    let places: Arc<[DVec3]> =
        (0..30).map(|i| origin + DVec3::new(-1.0, f64::from(i) - 15.0, 2.0)).collect();
    let drive = |number: u32, objects: &[usize], spacing_m: f64| {
        let mut chunk = street.points(objects, spacing_m);
        chunk.id.key.level = 5;
        chunk.id.key.x = number;
        chunk.origin.x -= 0.12 * f64::from(number % 2);
        let start = [2, 21, 9][number as usize % 3];
        let of_points = (0..chunk.positions.len()).map(|i| start + (i / 700 % 6) as u16).collect();
        let stations = PointStations { places: Arc::clone(&places), of_points };
        points_update(PointChunk { stations, ..chunk })
    };
    let taken = |id: &str, at: [f64; 3], heading: f64| {
        // Coarser than the views, so that their full level alone is looked up.
        let camera = camera(origin, at, heading, 5.0, 70.0, UVec2::new(160, 120));
        image_update(street.photograph(id, camera))
    };
    vec![
        mesh_update(street.mesh(&[2, 3], 0.05)),
        drive(0, &[0], 0.12),
        drive(1, &[0], 0.12),
        drive(2, &[1], 0.04),
        drive(3, &[1], 0.04),
        taken("a/east", [-1.0, -3.0, 2.0], 80.0),
        taken("b/east", [-0.5, 4.0, 2.2], 100.0),
        taken("c/north", [-0.9, -9.0, 2.1], 40.0),
    ]
}

#[test]
fn points_of_near_places_go_first() {
    for origin in [DVec3::ZERO, DVec3::new(651_187.3, 6_861_353.6, 42.8)] {
        let updates = updates(origin);
        for (y, heading) in [(0.5, 88.0), (-11.0, 60.0), (9.0, 120.0)] {
            let view = View::from(camera(origin, [-0.8, y, 1.8], heading, 3.0, 60.0, SIZE));
            let (frame, places, reference) = both(&updates, &view, Mode::Hybrid, settings());
            assert_in_place(&places, &reference, STEP_M, 10_000);
            let difference = reference.difference(&frame);
            assert!(difference.alike >= FRAME_ALIKE_SHARE, "{y}: {difference:?}");
            assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{y}: {difference:?}");
            // What it is compared with is not what it would be without.
            let alike = Settings { near_first: false, ..settings() };
            let (frame, ..) = both(&updates, &view, Mode::Hybrid, alike);
            let difference = reference.difference(&frame);
            assert!(difference.alike < FRAME_ALIKE_SHARE, "{y}: {difference:?}");
        }
    }
}

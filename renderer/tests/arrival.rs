//! Depth maps are refined as things arrive, change and leave, in any order, and end as if
//! everything had been there from the start.

mod common;

use common::*;
use flaneur_renderer::{Frame, Renderer, Settings};
use flaneur_scene::{NodeKey, PointStations, SceneUpdate, View};
use glam::{DVec3, UVec2};
use proptest::prelude::*;

const SIZE: UVec2 = UVec2::new(96, 72);

/// Settings under which ten photographs, each its own rig, have a map at once: more than there
/// are layers for at first.
fn settings() -> Settings {
    Settings {
        rigs: 10,
        depth_map_side: 128,
        exposure_gains: false,
        align: false,
        infer: false,
        ..Settings::default()
    }
}

/// Looking at the wall, along it, and at the box on the other side.
fn views() -> [View; 3] {
    [([-0.8, 0.5, 1.8], 88.0), ([3.5, -9.0, 1.8], 10.0), ([1.0, 2.0, 2.0], 310.0)]
        .map(|(at, heading)| camera(DVec3::ZERO, at, heading, 3.0, 60.0, SIZE).into())
}

/// Photographs in all directions along the street.
fn photographs(street: &Street) -> Vec<SceneUpdate> {
    (0..10u32)
        .map(|i| {
            let at = [-1.0 + 0.2 * f64::from(i % 3), f64::from(i) - 4.5, 2.0];
            let heading = [90.0, 20.0, 290.0][i as usize % 3];
            let camera = camera(street.origin, at, heading, 5.0, 80.0, UVec2::new(120, 90));
            image_update(street.photograph(&format!("p{i}/x"), camera))
        })
        .collect()
}

/// Everything that may be there, each in two versions: tiles of mesh, and nodes of an octree
/// down to its third level.
fn pieces(street: &Street) -> Vec<[SceneUpdate; 2]> {
    let mut moved = street.clone();
    moved.blocks[0].min.x -= 0.2;
    moved.blocks[2].max.x += 0.4;
    let tile = |objects: &[usize], x| {
        [street, &moved].map(|street| {
            let mut tile = street.mesh(objects, 0.15);
            tile.key.x = x;
            mesh_update(tile)
        })
    };
    let node = |level: u32, x: u32, object: usize, spacing_m: f64| {
        [1.0, 1.5].map(|coarser| {
            let mut chunk = street.points(&[object], spacing_m * coarser);
            // A share of the points, so that nodes overlap without being the same.
            let share = chunk.positions.iter().skip(x as usize).step_by(2).copied().collect();
            chunk.positions = share;
            chunk.id.key = NodeKey { level, x, y: 0, z: 0 };
            // From places along the street, so that maps have them in ranks.
            let places = (0..12).map(|i| street.origin + DVec3::Y * f64::from(i - 6)).collect();
            let station = |i: usize| (x as usize + i / 300) as u16 % 12;
            let of_points = (0..chunk.positions.len()).map(station).collect();
            chunk.stations = PointStations { places, of_points };
            points_update(chunk)
        })
    };
    vec![
        tile(&[0], 0),
        tile(&[2], 1),
        tile(&[3], 2),
        node(0, 0, 1, 0.15),
        node(1, 0, 1, 0.06),
        node(1, 1, 2, 0.3),
        node(2, 0, 1, 0.04),
        node(2, 1, 0, 0.2),
    ]
}

fn dropped(piece: &SceneUpdate) -> SceneUpdate {
    match piece {
        SceneUpdate::Mesh(tile) => SceneUpdate::DropMesh(tile.key),
        SceneUpdate::Points(chunk) => SceneUpdate::DropPoints(chunk.id),
        other => panic!("{other:?} is no piece"),
    }
}

fn frames(renderer: &mut Renderer) -> Vec<Frame> {
    views().iter().map(|view| renderer.render(view).expect("a frame")).collect()
}

/// What happens to a renderer.
#[derive(Clone, Copy, Debug)]
enum Event {
    Arrives { piece: usize, version: usize },
    Leaves { piece: usize },
    Looks { view: usize },
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        3 => (0..8usize, 0..2usize).prop_map(|(piece, version)| Event::Arrives { piece, version }),
        1 => (0..8usize).prop_map(|piece| Event::Leaves { piece }),
        2 => (0..3usize).prop_map(|view| Event::Looks { view }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10, ..ProptestConfig::default() })]

    #[test]
    fn maps_do_not_depend_on_their_history(events in prop::collection::vec(event(), 8..30)) {
        let street = Street::with_pole(DVec3::ZERO);
        let (photographs, pieces) = (photographs(&street), pieces(&street));
        let mut long_lived = renderer(settings(), photographs.clone());
        let mut there = vec![None; pieces.len()];
        for event in events {
            match event {
                Event::Arrives { piece, version } => {
                    long_lived.apply(pieces[piece][version].clone()).expect("a good update");
                    there[piece] = Some(version);
                }
                Event::Leaves { piece } => {
                    long_lived.apply(dropped(&pieces[piece][0])).expect("never wrong");
                    there[piece] = None;
                }
                Event::Looks { view } => drop(long_lived.render(&views()[view])),
            }
        }
        let mut fresh = renderer(settings(), photographs);
        for (versions, version) in pieces.iter().zip(&there) {
            if let Some(version) = version {
                fresh.apply(versions[*version].clone()).expect("a good update");
            }
        }
        let (found, expected) = (frames(&mut long_lived), frames(&mut fresh));
        // Not by prop_assert_eq, which would print the pictures.
        prop_assert!(found == expected, "another picture with {there:?}");
    }
}

/// More photographs than maps: those whose turn comes again find a map that is up to date,
/// although it was another's in between.
#[test]
fn maps_that_were_given_away_are_made_again() {
    let street = Street::with_pole(DVec3::ZERO);
    let tiny = |id: String, y: f64, heading: f64| {
        let camera = camera(DVec3::ZERO, [0.0, y, 2.0], heading, 5.0, 70.0, UVec2::new(16, 12));
        image_update(street.photograph(&id, camera))
    };
    // A hundred on each side; both sides exceed what there are layers for.
    let mut updates: Vec<SceneUpdate> = (0..100u32)
        .flat_map(|i| {
            let y = 0.06 * f64::from(i) - 3.0;
            [tiny(format!("e{i}/x"), y, 90.0), tiny(format!("w{i}/x"), y, 270.0)]
        })
        .collect();
    updates.push(mesh_update(street.mesh(&[0, 2, 3], 0.1)));
    let settings = Settings {
        rigs: 200,
        depth_map_side: 64,
        exposure_gains: false,
        align: false,
        infer: false,
        ..Settings::default()
    };
    let look = |heading| View::from(camera(DVec3::ZERO, [0.5, 0.0, 1.8], heading, 3.0, 50.0, SIZE));
    let (east, west) = (look(90.0), look(270.0));
    let pole = points_update(street.points(&[1], 0.05));
    let mut renderer_here = renderer(settings, updates.clone());
    let before = renderer_here.render(&east).expect("a frame");
    renderer_here.render(&west).expect("a frame");
    renderer_here.apply(pole.clone()).expect("a good update");
    renderer_here.render(&west).expect("a frame");
    let found = renderer_here.render(&east).expect("a frame");
    assert!(found.stats.images_drawn >= 90, "{:?}", found.stats);
    updates.push(pole);
    let expected = renderer(settings, updates).render(&east).expect("a frame");
    assert!(before != expected, "the pole hides some of the wall");
    assert!(found == expected);
}

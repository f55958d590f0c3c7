//! Photographs that are off are made to agree: what the device finds against f64.

use flaneur_scene::{ImageUpdate, PosedCamera, SceneUpdate, View};
use glam::{DVec2, DVec3, UVec2};

use super::common::{Street, camera, image_update, mesh_update, points_update};
use super::{Scene, both, keep_both, settings};
use crate::align::reference::{Level, displacements};
use crate::kernel_tests::channels::texels;
use crate::kernel_tests::gpu;
use crate::reference::field::Field;
use crate::tolerances::{
    ALIGNED_APART_PX, ALIGNED_PX, ALIGNED_SHARE, FRAME_ALIKE_SHARE, SIGHT_BRIGHTNESS, SIGHT_SHARE,
};
use crate::{Mode, Renderer, Settings};

const SIZE: UVec2 = UVec2::new(320, 240);

fn with_alignment() -> Settings {
    Settings { align: true, ..settings() }
}

/// Photographs of a street, each said to be some centimetres from its place, and a third rig
/// farther away.
fn updates(origin: DVec3) -> Vec<SceneUpdate> {
    let street = Street { spots: 0.5, ..Street::with_pole(origin) };
    let taken = |id: &str, at: [f64; 3], heading: f64, off: DVec3| {
        let camera = camera(origin, at, heading, 5.0, 75.0, UVec2::new(480, 360));
        let image = street.photograph(id, camera);
        let camera = PosedCamera { centre: camera.centre + off, ..camera };
        image_update(ImageUpdate { camera, ..image })
    };
    let off = DVec3::new(0.02, 0.05, -0.03);
    vec![
        mesh_update(street.mesh(&[0, 2, 3], 0.05)),
        points_update(street.points(&[1], 0.03)),
        taken("a/east", [-1.0, -0.4, 1.9], 85.0, off),
        taken("a/north", [-1.0, -0.3, 1.9], 20.0, off),
        taken("b/east", [-0.9, 1.6, 2.0], 95.0, -off),
        taken("c/east", [-0.5, 6.0, 2.2], 110.0, DVec3::ZERO),
    ]
}

fn view(origin: DVec3) -> View {
    View::from(camera(origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE))
}

/// What the device has of each level, finest first: what both rigs show, and the displacement.
fn on_device(renderer: &Renderer) -> (Vec<Level>, Vec<Field<DVec2>>) {
    let sight = |[brightness, sees, ..]: &[f32; 4]| (*sees > 0.5).then_some(f64::from(*brightness));
    let levels = renderer.align_pass().last_levels();
    let (sights, across) = renderer.align_pass().last_sights().expect("two rigs");
    let shown = texels(sights).each(sight);
    levels
        .map(|(grid, origin, displaced)| {
            let sights = [0, across].map(|aside| {
                let first = origin + UVec2::new(aside, 0);
                Field::new(grid.cells, |cell| shown.at(first + cell))
            });
            let level = Level { step: grid.step.into(), sights };
            (level, texels(displaced).each(|[x, y, ..]| DVec2::new((*x).into(), (*y).into())))
        })
        .unzip()
}

fn rendered(origin: DVec3) -> (Renderer, Scene) {
    let mut renderer = Renderer::with_settings(gpu(), with_alignment());
    let mut scene = Scene::new(with_alignment());
    for update in updates(origin) {
        scene.apply(update.clone());
        renderer.apply(update).expect("a good update");
    }
    renderer.render(&view(origin)).expect("a frame");
    (renderer, scene)
}

/// From what the device's photographs show, every level.
#[test]
fn displacements_agree_with_their_reference() {
    let (renderer, scene) = rendered(DVec3::ZERO);
    let (levels, found) = on_device(&renderer);
    assert_eq!(levels.len(), 2);
    let shares = scene.aligned(&view(DVec3::ZERO)).expect("two rigs").1.shares;
    assert!(shares.nearest > 0.2 && shares.applied == 1.0, "{shares:?}");
    for (finest, found) in found.iter().enumerate() {
        let expected = displacements(&levels[finest..], shares.nearest);
        let (mut worst, mut largest) = (0.0f64, 0.0f64);
        for (found, expected) in found.values.iter().zip(&expected.values) {
            worst = worst.max(found.distance(*expected));
            largest = largest.max(expected.length());
        }
        println!("level {finest}: up to {largest} pixels, off by {worst}");
        assert!(worst < ALIGNED_PX, "{worst}");
        assert!(largest > 1.0, "{largest}");
    }
}

/// From the scene itself.
#[test]
fn what_is_aligned_agrees_with_its_reference() {
    for origin in [DVec3::ZERO, DVec3::new(651_187.3, 6_861_353.6, 42.8)] {
        let (renderer, scene) = rendered(origin);
        let (levels, found) = on_device(&renderer);
        let (expected_levels, expected) = scene.aligned(&view(origin)).expect("two rigs");
        for (found, expected) in levels.iter().zip(&expected_levels) {
            for (found, expected) in found.sights.iter().zip(&expected.sights) {
                let (mut same, mut seen, mut worst) = (0, 0, 0.0f64);
                for (found, expected) in found.values.iter().zip(&expected.values) {
                    match (found, expected) {
                        (Some(found), Some(expected)) => {
                            seen += 1;
                            worst = worst.max((found - expected).abs());
                            same += usize::from((found - expected).abs() < SIGHT_BRIGHTNESS);
                        }
                        (None, None) => same += 1,
                        _ => (),
                    }
                }
                let all = expected.values.len();
                println!("{seen} of {all} seen, {same} alike, off by up to {worst}");
                assert!(seen > all / 3 && same as f64 > SIGHT_SHARE * all as f64);
            }
        }
        let mut off: Vec<f64> = std::iter::zip(&found[0].values, &expected.displacements.values)
            .map(|(found, expected)| found.distance(*expected))
            .collect();
        off.sort_by(f64::total_cmp);
        let at = |share: f64| off[((off.len() - 1) as f64 * share) as usize];
        println!("off by {:.3} pixels, at most {:.3}", at(0.5), at(1.0));
        assert!(at(ALIGNED_SHARE) < ALIGNED_APART_PX, "{}", at(ALIGNED_SHARE));
    }
}

#[test]
fn frames_with_alignment() {
    let view = view(DVec3::ZERO);
    let (frame, _, reference) = both(&updates(DVec3::ZERO), &view, Mode::Hybrid, with_alignment());
    keep_both(&frame, &reference, "aligned");
    let difference = reference.difference(&frame);
    let apart = both(&updates(DVec3::ZERO), &view, Mode::Hybrid, settings()).2.difference(&frame);
    println!("{difference:?}, without alignment {apart:?}");
    assert!(difference.compared > 60_000, "{difference:?}");
    assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
    assert!(apart.alike < 0.96, "nothing was to be aligned: {apart:?}");
}

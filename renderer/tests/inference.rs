//! Pictures of what no geometry tells of.

mod common;

use common::tolerances::{INFERRED_JUMPING_SHARE, INFERRED_STEP_255};
use common::*;
use flaneur_renderer::{Frame, Mode, Settings, Surface};
use flaneur_scene::{Lens, SceneUpdate, View};
use glam::{DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(320, 240);
const PHOTO: UVec2 = UVec2::new(640, 480);
/// What the photographs show of the sky.
const SKY: DVec3 = DVec3::new(1.0, 0.0, 1.0);

/// Looks at the wall, which the mesh lacks, from between the photographs.
fn view(street: &Street) -> View {
    View::from(camera(street.origin, [-0.8, 0.2, 1.8], 88.0, 12.0, 60.0, SIZE))
}

/// Photographs a metre apart; of the mesh the ground and the far box only.
fn without_wall(street: &Street) -> Vec<SceneUpdate> {
    let place = |y: f64| camera(street.origin, [-0.9, y, 1.9], 90.0, 14.0, 80.0, PHOTO);
    let mut updates: Vec<SceneUpdate> = [("a/east", -0.9), ("b/east", 0.1), ("c/east", 1.1)]
        .into_iter()
        .map(|(id, y)| image_update(street.photograph(id, place(y))))
        .collect();
    updates.push(mesh_update(street.mesh(&[1, 2], 0.0)));
    updates
}

/// A wall on the ground, and a box far off: no pole before it.
fn street() -> Street {
    Street {
        blocks: vec![
            block([6.0, -20.0, 0.0], [10.0, 20.0, 6.0]),
            block([-9.0, 4.0, 0.0], [-5.0, 14.0, 7.0]),
        ],
        ..Street::with_pole(DVec3::ZERO)
    }
}

fn frame(settings: Settings) -> Frame {
    let street = street();
    renderer(settings, without_wall(&street)).render(&view(&street)).expect("a frame")
}

fn off() -> Settings {
    Settings { infer: false, ..Settings::default() }
}

/// Mean difference from the truth, 255ths, of the pixels that show `object`, or the sky.
fn missed(frame: &Frame, object: Option<usize>) -> f64 {
    missed_through(frame, &view(&street()), object)
}

/// The same of a frame of `view`.
fn missed_through(frame: &Frame, view: &View, object: Option<usize>) -> f64 {
    let truth = street().picture(&view.camera);
    let differences: Vec<f64> = (0..truth.len())
        .filter(|&i| {
            truth[i].map(|(hit, _)| hit.object) == object && !frame.surfaces[i].is_geometry()
        })
        .map(|i| difference(&frame.rgba, i, truth[i].map_or(SKY, |(_, colour)| colour)))
        .collect();
    assert!(differences.len() > 5000, "{} pixels of {object:?}", differences.len());
    differences.iter().sum::<f64>() / differences.len() as f64
}

/// Nothing tells of the wall but the photographs. The depths between find it better than the two
/// alone; both are nearer to the truth than the background.
#[test]
fn a_missing_wall_is_seen_where_the_photographs_agree() {
    let alone = frame(Settings { inferred_hypotheses: 0, ..Settings::default() });
    let between = frame(Settings::default());
    keep(&between, "missing-wall");
    let [nothing, alone, between] = [&frame(off()), &alone, &between].map(|f| missed(f, Some(0)));
    println!("off by {nothing:.1}, with two hypotheses {alone:.1}, with all {between:.1}");
    assert!(between < 0.9 * alone && between < 0.4 * nothing, "{between} {alone} {nothing}");
}

#[test]
fn the_sky_has_the_colour_that_photographs_show() {
    let sky = missed(&frame(Settings::default()), None);
    assert!(sky < 12.0 && missed(&frame(off()), None) > 100.0, "{sky}");
}

/// Each model of lens has its own rays.
#[test]
fn a_lens_that_distorts_finds_the_same_sky_and_wall() {
    let street = street();
    let straight = view(&street).camera;
    for distortion in DISTORTIONS {
        let lens = Lens { distortion, ..straight.lens };
        let view = View::from(with_lens(straight, lens));
        let mut renderer = renderer(Settings::default(), without_wall(&street));
        let frame = renderer.render(&view).expect("a frame");
        keep(&frame, "inferred-distorted");
        let [sky, wall] = [None, Some(0)].map(|object| missed_through(&frame, &view, object));
        println!("{distortion:?}: sky off by {sky:.1}, wall by {wall:.1}");
        assert!(sky < 3.0 && wall < 10.0, "{distortion:?}: {sky} {wall}");
    }
}

#[test]
fn what_is_inferred_is_marked_and_changes_nothing_else() {
    // Alignment would look at what is inferred, too.
    let alone = Settings { align: false, ..Settings::default() };
    let (with, without) = (frame(alone), frame(Settings { infer: false, ..alone }));
    let mut inferred = 0;
    for (i, (&now, &before)) in with.surfaces.iter().zip(&without.surfaces).enumerate() {
        if before == Surface::Background {
            assert!(!now.is_geometry() && !now.is_coloured(), "{now:?}");
            inferred += u64::from(now == Surface::Inferred);
        } else {
            assert_eq!(now, before);
            assert_eq!(with.rgba[4 * i..4 * i + 4], without.rgba[4 * i..4 * i + 4], "pixel {i}");
        }
    }
    assert_eq!((with.stats.inferred_pixels, without.stats.inferred_pixels), (inferred, 0));
    assert_eq!(with.stats.geometry_pixels, without.stats.geometry_pixels);
    assert!(inferred > 20_000, "{inferred}");
}

/// What is inferred, or completed, is shown but has no depth: measuring never uses it.
#[test]
fn what_is_inferred_is_not_measured() {
    let street = street();
    let mut renderer = renderer(Settings::default(), without_wall(&street));
    let frame = renderer.render(&view(&street)).expect("a frame");
    assert!(frame.stats.inferred_pixels > 20_000, "{:?}", frame.stats);
    assert!(frame.stats.geometry_pixels > 5_000, "{:?}", frame.stats);
    let depths = renderer.last_depths().expect("depths");
    assert_eq!(depths.len(), frame.surfaces.len());
    for (i, (depth, surface)) in depths.iter().zip(&frame.surfaces).enumerate() {
        assert_eq!(depth.is_some(), surface.is_geometry(), "pixel {i}: {depth:?}, {surface:?}");
    }
}

#[test]
fn modes_that_measure_infer_nothing() {
    let street = street();
    let mut renderer = renderer(Settings::default(), without_wall(&street));
    for mode in [Mode::Depth, Mode::Normals, Mode::Mesh, Mode::Points, Mode::Wireframe] {
        let frame = renderer.render_as(&view(&street), mode).expect("a frame");
        assert_eq!(frame.stats.inferred_pixels, 0, "{mode:?}");
    }
    let frame = renderer.render_as(&view(&street), Mode::Uncertainty).expect("a frame");
    let marked = frame.surfaces.iter().zip(frame.rgba.chunks(4));
    let marked = marked.filter(|(surface, _)| **surface == Surface::Inferred);
    assert!(marked.clone().count() > 20_000);
    assert!(marked.clone().all(|(_, rgba)| rgba[0] > 150 && rgba[1] < 60 && rgba[2] > 150));
}

#[test]
fn nothing_at_all_is_inferred_without_photographs() {
    let street = street();
    let updates = vec![mesh_update(street.mesh(&[1], 0.0))];
    let frame = renderer(Settings::default(), updates).render(&view(&street)).expect("a frame");
    assert_eq!(frame.stats.inferred_pixels, 0);
    assert!(frame.surfaces.contains(&Surface::Background));
}

/// The eye walks from between two photographs by steps of a centimetre, where colours depend on
/// depths the most. Depths that changed their minds would show as pixels that jump.
#[test]
fn what_is_inferred_changes_little_by_little() {
    let street = street();
    let mut renderer = renderer(Settings::default(), without_wall(&street));
    let mut before: Option<Frame> = None;
    for i in 0..12 {
        let y = 0.5 + 0.01 * f64::from(i);
        let camera = camera(street.origin, [-0.8, y, 1.8], 88.0, 12.0, 60.0, SIZE);
        let now = renderer.render(&View::from(camera)).expect("a frame");
        if let Some(before) = before {
            let steps = inferred_steps(&now, &before);
            assert!(steps.len() > 20_000, "{} pixels", steps.len());
            let jumping = steps.iter().filter(|&&step| step > INFERRED_STEP_255).count();
            let share = jumping as f64 / steps.len() as f64;
            assert!(share < INFERRED_JUMPING_SHARE, "{share} of step {i}");
            // The picture moves all the same.
            assert!(steps.iter().any(|&step| step > 1.0), "step {i}");
        }
        before = Some(now);
    }
}

/// By how much, 255ths, the pixels differ that are inferred in both pictures.
fn inferred_steps(now: &Frame, before: &Frame) -> Vec<f64> {
    let inferred = |i: &usize| [now, before].iter().all(|f| f.surfaces[*i] == Surface::Inferred);
    (0..now.surfaces.len())
        .filter(inferred)
        .map(|i| {
            let channels = 4 * i..4 * i + 3;
            let steps = channels.map(|c| f64::from(now.rgba[c].abs_diff(before.rgba[c])));
            steps.fold(0.0, f64::max)
        })
        .collect()
}

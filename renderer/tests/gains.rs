//! Photographs that were exposed differently.

mod common;

use common::*;
use flaneur_renderer::{Frame, Settings};
use flaneur_scene::{PosedCamera, SceneUpdate, View, linear_from_srgb, srgb_from_linear};
use glam::{DVec3, UVec2};
use tolerances::{EXPOSED_ALIKE, FILTERED_255, SETTLING_MEAN_255};

const SIZE: UVec2 = UVec2::new(240, 160);
/// Exposures of the photographs, for linear red, green and blue.
const EXPOSURES: [[f64; 3]; 4] =
    [[1.0, 1.0, 0.95], [0.6, 0.62, 0.6], [0.95, 0.9, 0.9], [0.55, 0.55, 0.6]];

fn view(street: &Street) -> View {
    View::from(camera(street.origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE))
}

/// Photographs along a wall, each with its own exposure, and the wall.
fn updates(street: &Street) -> Vec<SceneUpdate> {
    let mut updates = vec![mesh_update(street.mesh(&[0, 1, 2, 3], 0.0))];
    for (i, exposure) in EXPOSURES.iter().enumerate() {
        let at = [-1.0, -5.0 + 3.0 * i as f64, 2.0 + 0.1 * i as f64];
        let camera = camera(street.origin, at, 90.0, 5.0, 70.0, UVec2::new(480, 360));
        let mut image = street.photograph(&format!("{i}/x"), camera);
        for pixel in image.rgba.chunks_exact_mut(4) {
            for (value, exposure) in pixel.iter_mut().zip(exposure) {
                let linear = linear_from_srgb(f64::from(*value) / 255.0) * exposure;
                *value = (255.0 * srgb_from_linear(linear)).round() as u8;
            }
        }
        updates.push(image_update(image));
    }
    updates
}

/// How much brighter than the truth the pixels are that lie away from edges, sorted: green.
fn brightness(street: &Street, frame: &Frame, camera: &PosedCamera) -> Vec<f64> {
    let truth = street.picture(camera);
    let mut ratios: Vec<f64> = truth
        .iter()
        .enumerate()
        .filter(|(i, _)| frame.surfaces[*i].is_coloured() && is_interior(&truth, SIZE, *i, 4))
        .filter_map(|(i, seen)| {
            let (_, colour) = seen.as_ref()?;
            let found = linear_from_srgb(f64::from(frame.rgba[4 * i + 1]) / 255.0);
            Some(found / linear_from_srgb(colour.y))
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

/// Brightness is only known up to one factor, but it is the same all over the picture.
#[test]
fn differences_of_exposure_are_taken_away() {
    let street = Street::with_pole(DVec3::ZERO);
    let view = view(&street);
    let spread = |exposure_gains, name| {
        // Aligned photographs would differ by where they are looked up, too.
        let settings = Settings { exposure_gains, align: false, ..Settings::default() };
        let frame = renderer(settings, updates(&street)).render(&view).expect("a frame");
        keep(&frame, name);
        let ratios = brightness(&street, &frame, &view.camera);
        assert!(ratios.len() > 20_000, "{}", ratios.len());
        let at = |share: f64| ratios[(share * ratios.len() as f64) as usize];
        at(0.99) / at(0.01) - 1.0
    };
    let (with, without) = (spread(true, "gains"), spread(false, "no_gains"));
    println!("brightness differs by {with:.3}, without gains by {without:.3}");
    assert!(with < EXPOSED_ALIKE && without > 0.3, "{with} {without}");
}

/// Neither the order of arrival nor what was looked at before changes them, once the view jumps.
#[test]
fn gains_depend_on_what_is_there() {
    let street = Street::with_pole(DVec3::new(651_000.0, 6_861_000.0, 40.0));
    let here = view(&street);
    let mut there = here;
    there.camera.centre.y += 1.0;
    let all = updates(&street);
    let expected = renderer(Settings::default(), all.clone()).render(&here).expect("a frame");
    for order in [[4, 3, 2, 1, 0], [1, 3, 0, 4, 2]] {
        let mut renderer = renderer(Settings::default(), Vec::new());
        for i in order {
            renderer.apply(all[i].clone()).expect("a good update");
            renderer.render(&here).expect("a frame");
        }
        renderer.render(&there).expect("a frame");
        let frame = renderer.render(&here).expect("a frame");
        // Photographs lie elsewhere in their textures, where filtering rounds otherwise.
        let off = frame.rgba.iter().zip(&expected.rgba).map(|(a, b)| a.abs_diff(*b)).max();
        let alike = off.is_some_and(|off| f64::from(off) <= FILTERED_255);
        assert!(alike, "order {order:?} gives another picture: {off:?}");
    }
}

/// A photograph arrives that is far darker: those that are there go to their new gains in steps.
#[test]
fn what_is_on_display_does_not_jump() {
    let street = Street::with_pole(DVec3::ZERO);
    let view = view(&street);
    let mut all = updates(&street);
    let last = all.pop().expect("photographs");
    let mut renderer = renderer(Settings::default(), all);
    let mean = |frame: &Frame| {
        let sum: f64 = frame.rgba.iter().map(|value| f64::from(*value)).sum();
        sum / frame.rgba.len() as f64
    };
    let before = mean(&renderer.render(&view).expect("a frame"));
    renderer.apply(last).expect("a good update");
    let mut means: Vec<f64> =
        (0..50).map(|_| mean(&renderer.render(&view).expect("a frame"))).collect();
    // The new photograph shows at once; after it nothing changes by more than a byte a frame.
    let steps: Vec<f64> = means.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let settled = means.pop().expect("frames");
    assert!(steps.iter().all(|step| *step < SETTLING_MEAN_255), "{before} {steps:?}");
    assert!((settled - means[0]).abs() > 0.1, "nothing was to be adjusted: {before} {means:?}");
    assert_eq!(steps.last(), Some(&0.0), "it comes to an end");
}

/// Two take turns, in pictures of different sizes: each sees what they would see alone.
#[test]
fn who_takes_turns_sees_no_jump() {
    let street = Street::with_pole(DVec3::ZERO);
    let aside = camera(street.origin, [-0.5, -1.5, 1.8], 70.0, 8.0, 60.0, UVec2::new(160, 120));
    let views = [view(&street), View::from(aside)];
    // Frames before the dark photograph arrives, and after it, of those whose turns they are.
    let walk = |turns: &[u64], viewers: [u64; 2]| -> Vec<Frame> {
        let mut all = updates(&street);
        let last = all.pop().expect("photographs");
        let mut renderer = renderer(Settings::default(), all);
        let mut frames = Vec::new();
        for (round, last) in [None, Some(last)].into_iter().enumerate() {
            last.into_iter().for_each(|last| drop(renderer.apply(last).expect("a good update")));
            for _ in 0..1 + 3 * round {
                for &turn in turns {
                    renderer.look_as(viewers[turn as usize]);
                    frames.push(renderer.render(&views[turn as usize]).expect("a frame"));
                }
            }
        }
        frames
    };
    let (mine, theirs) = (walk(&[0], [7, 9]), walk(&[1], [7, 9]));
    let both = walk(&[0, 1], [7, 9]);
    let expected: Vec<&Frame> = mine.iter().zip(&theirs).flat_map(|(a, b)| [a, b]).collect();
    let same = |a: &Frame, b: &Frame| a.rgba == b.rgba;
    assert!(both.iter().zip(&expected).all(|(a, b)| same(a, b)), "frames differ");
    // As one viewer they would disturb each other.
    let one = walk(&[0, 1], [7, 7]);
    assert!(!one.iter().zip(&expected).all(|(a, b)| same(a, b)), "it makes no difference");

    // Who is forgotten begins anew, and gives back what was remembered of them.
    let mut renderer = renderer(Settings::default(), updates(&street));
    renderer.render(&views[0]).expect("a frame");
    let alone = renderer.memory().inference;
    renderer.look_as(1);
    renderer.render(&views[0]).expect("a frame");
    assert!(renderer.memory().inference > alone, "another's picture is remembered");
    renderer.forget_viewer(0);
    assert_eq!(renderer.memory().inference, alone);
    for viewer in 2..70 {
        renderer.look_as(viewer);
        renderer.render(&views[0]).expect("a frame");
    }
    let most = renderer.memory().inference - alone;
    renderer.look_as(0);
    renderer.render(&views[0]).expect("a frame");
    assert_eq!(renderer.memory().inference - alone, most, "so many, and no more");
}

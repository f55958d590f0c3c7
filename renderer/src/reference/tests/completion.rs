//! Where no photograph reaches: frames that take the colours around, against f64.

use flaneur_scene::View;
use glam::DVec3;

use super::common::camera;
use super::inference::{inferring, updates};
use super::{SIZE, both, keep_both, settings};
use crate::tolerances::{FRAME_ALIKE_SHARE, INFERRED_ALIKE_SHARE};
use crate::{Frame, Mode, Settings, Surface};

/// Looks over the upper borders of the photographs, and beyond their sides.
fn view(origin: DVec3) -> View {
    View::from(camera(origin, [-0.8, 0.5, 1.8], 70.0, 34.0, 60.0, SIZE))
}

#[test]
fn frames_with_completion() {
    let far = DVec3::new(651_187.3, 6_861_353.6, 42.8);
    let cases = [
        (DVec3::ZERO, Mode::Hybrid),
        (DVec3::ZERO, Mode::Uncertainty),
        (DVec3::ZERO, Mode::Sources),
        (far, Mode::Hybrid),
    ];
    for (origin, mode) in cases {
        let (frame, _, reference) = both(&updates(origin), &view(origin), mode, inferring());
        keep_both(&frame, &reference, &format!("completed-{mode:?}"));
        let difference = reference.difference(&frame);
        println!("{mode:?}: {difference:?}");
        assert!(difference.compared > 20_000, "{difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
        assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{difference:?}");
        let pixels = &reference.pixels;
        let of = |surface| (0..pixels.len()).filter(move |&i| pixels[i].surface == surface);
        let completed = of(Surface::Completed).count();
        if mode == Mode::Sources {
            assert_eq!(completed, 0);
            assert!(of(Surface::Background).count() > 5_000);
            continue;
        }
        // Those in doubt, too.
        let is_alike = |i: &usize| {
            let bytes = frame.rgba[4 * i..4 * i + 3].iter().map(|b| f64::from(*b));
            let exact = (reference.pixels[*i].rgb * 255.0).round().to_array();
            bytes.zip(exact).all(|(found, exact)| (found - exact).abs() <= 1.0)
        };
        let alike = of(Surface::Completed).filter(is_alike).count();
        println!("{alike} of {completed} completed alike");
        assert!(completed > 5_000, "{completed}");
        assert!(alike as f64 > INFERRED_ALIKE_SHARE * completed as f64, "{alike} of {completed}");
        assert!(frame.stats.completed_pixels.abs_diff(completed as u64) < 500);
        assert!(!Surface::Completed.is_geometry() && !Surface::Completed.is_coloured());
    }
}

/// Of a scene whose photographs look elsewhere nothing is known, and nothing made up.
#[test]
fn what_nothing_around_is_known_of_stays_background() {
    let origin = DVec3::ZERO;
    let away = View::from(camera(origin, [-0.8, 0.5, 1.8], 265.0, 40.0, 40.0, SIZE));
    let (frame, _, reference) = both(&updates(origin), &away, Mode::Hybrid, inferring());
    assert_eq!((frame.stats.completed_pixels, frame.stats.inferred_pixels), (0, 0));
    let shown = reference.pixels.iter().map(|pixel| pixel.surface);
    assert!(frame.surfaces.iter().copied().eq(shown));
    let [r, g, b] = Settings::default().background;
    let background = frame.rgba.chunks(4).zip(&frame.surfaces);
    let background = background.filter(|(_, shows)| **shows == Surface::Background);
    assert!(background.clone().count() > 10_000);
    assert!(background.clone().all(|(rgba, _)| rgba == [r, g, b, 255]));
}

/// Looks down to where the photographs, which look ahead, see no ground.
fn down(origin: DVec3) -> View {
    View::from(camera(origin, [-0.8, 0.5, 1.8], 88.0, -38.0, 60.0, SIZE))
}

/// The ground that nobody saw takes the colours of the ground around; it stays known as uncoloured.
#[test]
fn the_ground_that_nobody_saw_is_like_that_around() {
    for origin in [DVec3::ZERO, DVec3::new(651_187.3, 6_861_353.6, 42.8)] {
        let shown = |mode, settings| both(&updates(origin), &down(origin), mode, settings);
        let (frame, _, reference) = shown(Mode::Hybrid, inferring());
        keep_both(&frame, &reference, "ground");
        let difference = reference.difference(&frame);
        println!("{difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
        assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{difference:?}");
        let is_bare = |i: &usize| frame.surfaces[*i] == Surface::MeshUncoloured;
        let bare: Vec<usize> = (0..frame.surfaces.len()).filter(is_bare).collect();
        assert!(bare.len() > 5_000, "{}", bare.len());
        let changed = |other: &Frame| {
            let rgb = |frame: &Frame, i: usize| frame.rgba[4 * i..4 * i + 3].to_vec();
            bare.iter().filter(|&&i| rgb(other, i) != rgb(&frame, i)).count()
        };
        // Without them it is grey.
        let (grey, ..) = shown(Mode::Hybrid, settings());
        assert!(changed(&grey) > bare.len() * 9 / 10, "{} of {}", changed(&grey), bare.len());
        // In the doubtful modes nothing is made up.
        let (doubt, _, reference) = shown(Mode::Uncertainty, inferring());
        let difference = reference.difference(&doubt);
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
        assert!(bare.iter().all(|&i| doubt.surfaces[i] == Surface::MeshUncoloured));
    }
}

//! The edges of masks.

mod common;

use common::*;
use flaneur_renderer::{Frame, Settings};
use flaneur_scene::View;
use glam::{DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(320, 200);
const PHOTO: UVec2 = UVec2::new(640, 480);

/// Of two photographs one is darker, and its mask hides all of it right of its middle, with an alpha that rises over `feather_px` pixels.
fn rendered(street: &Street, feather_px: u32) -> Frame {
    let camera = |at| camera(street.origin, at, 90.0, 5.0, 70.0, PHOTO);
    let mut dark = street.photograph("dark/x", camera([-1.2, 0.9, 1.8]));
    for (x, pixel) in (0..PHOTO.x).cycle().zip(dark.rgba.chunks_exact_mut(4)) {
        let inside = (PHOTO.x / 2).saturating_sub(x);
        pixel[3] = (255 * inside / feather_px).min(255) as u8;
        pixel[..3].iter_mut().for_each(|value| *value = (f64::from(*value) * 0.8) as u8);
        if inside == 0 {
            pixel[..3].copy_from_slice(&[255, 0, 255]);
        }
    }
    let bright = street.photograph("bright/x", camera([-2.0, -0.5, 2.0]));
    let updates =
        vec![mesh_update(street.mesh(&[0, 1], 0.0)), image_update(dark), image_update(bright)];
    let settings = Settings { exposure_gains: false, ..Settings::default() };
    renderer(settings, updates).render(&view(street)).expect("a frame")
}

fn view(street: &Street) -> View {
    View::from(camera(street.origin, [-0.7, 0.5, 1.8], 90.0, 3.0, 60.0, SIZE))
}

/// The largest change, from one pixel of a row to the next, of how much darker the picture is than
/// the truth.
fn steepest(street: &Street, frame: &Frame) -> f64 {
    let truth = street.picture(&view(street).camera);
    let ratio = |i: usize| {
        let seen = truth[i].filter(|_| frame.surfaces[i].is_coloured());
        let interior = is_interior(&truth, SIZE, i, 3);
        seen.filter(|_| interior).map(|(_, c)| f64::from(frame.rgba[4 * i + 1]) / (255.0 * c.y))
    };
    let width = SIZE.x as usize;
    (0..truth.len() - 1)
        .filter(|i| (i + 1) % width != 0)
        .filter_map(|i| Some((ratio(i + 1)? - ratio(i)?).abs()))
        .fold(0.0, f64::max)
}

#[test]
fn the_edge_of_a_feathered_mask_does_not_show() {
    let mut street = Street::with_pole(DVec3::ZERO);
    // The wall alone: nothing hides a part of it.
    street.blocks.truncate(1);
    let (hard, soft) = (rendered(&street, 1), rendered(&street, 32));
    keep(&hard, "mask_hard");
    keep(&soft, "mask_soft");
    let (hard_step, soft_step) = (steepest(&street, &hard), steepest(&street, &soft));
    println!("steepest change of brightness: {hard_step:.3} hard, {soft_step:.3} feathered");
    assert!(hard_step > 0.12 && soft_step < tolerances::FEATHERED_STEP, "{hard_step} {soft_step}");
    let seen = soft.surfaces.iter().filter(|surface| surface.is_coloured()).count();
    assert!(seen > 40_000, "{seen}");
}

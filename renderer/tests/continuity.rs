//! Nothing pops: the colour of a place changes little as the eye moves a little, also where
//! rigs enter and leave the set that colours a frame.
//!
//! Every rig's photographs have an exposure of their own, so that a rig that came or went at
//! once would show, or every camera's. Places on the wall are followed from frame to frame by projecting them, and
//! the frame is looked up between its pixels; what the same look-up of the truth changes by is
//! taken off.

mod common;

use common::*;
use flaneur_renderer::{Renderer, Settings};
use flaneur_scene::{PosedCamera, SceneUpdate, View};
use glam::{DVec2, DVec3, UVec2};
use tolerances::{EXPOSED_STEP_255, GAINS_STEP_255, STEP_255};

const SIZE: UVec2 = UVec2::new(120, 90);
const ORIGIN: DVec3 = DVec3::new(651_000.0, 6_861_000.0, 40.0);

/// What has an exposure of its own, differing by up to 30 %.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Exposed {
    Nothing,
    Rigs,
    /// All cameras towards the south are darker.
    Cameras,
}

/// Rigs every 1.5 m along the street, a little off its line, each of two cameras 20 cm apart.
fn rigs(street: &Street, exposed: Exposed) -> Vec<SceneUpdate> {
    (0..9u32)
        .flat_map(|i| {
            let y = 1.5 * f64::from(i) - 6.0;
            let x = if i % 2 == 0 { -0.9 } else { -0.5 };
            [("east", 0.0, 90.0), ("south", 0.2, 140.0)].map(|(name, aside, heading)| {
                let exposure = match exposed {
                    Exposed::Rigs => [1.0, 0.7, 0.95, 0.75][i as usize % 4],
                    Exposed::Cameras if name == "south" => 0.7,
                    _ => 1.0,
                };
                let at = [x + aside, y, 2.0];
                let camera = camera(street.origin, at, heading, 5.0, 75.0, UVec2::new(240, 180));
                let mut image = street.photograph(&format!("r{i}/{name}"), camera);
                for (i, byte) in image.rgba.iter_mut().enumerate() {
                    if i % 4 != 3 {
                        *byte = (f64::from(*byte) * exposure).round() as u8;
                    }
                }
                image_update(image)
            })
        })
        .collect()
}

/// A wall on flat ground, the wall as mesh or as points.
fn scene(exposed: Exposed, points: bool, gains: bool) -> (Street, Renderer) {
    let mut street = Street::with_pole(ORIGIN);
    // The wall alone.
    street.blocks.truncate(1);
    let mut updates = rigs(&street, exposed);
    let meshed: &[usize] = if points { &[1] } else { &[0, 1] };
    updates.push(mesh_update(street.mesh(meshed, 0.1)));
    if points {
        updates.push(points_update(street.points(&[0], 0.08)));
    }
    let settings = Settings { rigs: 3, exposure_gains: gains, infer: false, ..Settings::default() };
    let renderer = renderer(settings, updates);
    (street, renderer)
}

/// Places on the wall, one every 30 cm.
fn places(street: &Street) -> Vec<DVec3> {
    (0..60 * 12)
        .map(|i| {
            let (along, up) = (f64::from(i % 60), f64::from(i / 60));
            street.origin + DVec3::new(6.0, 0.3 * along - 9.0, 0.3 * up + 0.6)
        })
        .collect()
}

/// Bytes of a picture between its pixels where a camera sees a place; `None` within two pixels
/// of the border, and where a pixel has none.
fn look_up(
    rgb: impl Fn(usize) -> Option<DVec3>,
    camera: &PosedCamera,
    place: DVec3,
) -> Option<DVec3> {
    let (pixel, _) = camera.project(place)?;
    let size = camera.lens.size.as_dvec2();
    let inside = pixel.min(size - pixel).min_element() > 2.0;
    let (first, t) = ((pixel - 0.5).floor(), (pixel - 0.5) - (pixel - 0.5).floor());
    let at = |dx: f64, dy: f64| {
        let cell = (first + DVec2::new(dx, dy)).as_uvec2();
        rgb((cell.y * camera.lens.size.x + cell.x) as usize)
    };
    if !inside {
        return None;
    }
    let (above, below) =
        (at(0.0, 0.0)?.lerp(at(1.0, 0.0)?, t.x), at(0.0, 1.0)?.lerp(at(1.0, 1.0)?, t.x));
    Some(above.lerp(below, t.y))
}

/// What each place looks like in a frame, less what it looks like in truth, in bytes.
struct Look(Vec<Option<DVec3>>);

impl Look {
    fn at(renderer: &mut Renderer, street: &Street, camera: PosedCamera) -> Self {
        let frame = renderer.render(&View::from(camera)).expect("a frame");
        let truth = street.picture(&camera);
        let rendered = |i: usize| {
            let p = &frame.rgba[4 * i..];
            let bytes = DVec3::new(p[0].into(), p[1].into(), p[2].into());
            // What no photograph sees has no colour to follow.
            frame.surfaces[i].is_coloured().then_some(bytes)
        };
        let real = |i: usize| truth[i].map(|(_, colour)| colour * 255.0);
        let off = places(street)
            .into_iter()
            .map(|place| Some(look_up(rendered, &camera, place)? - look_up(real, &camera, place)?));
        Self(off.collect())
    }

    /// The largest change of a place between two looks, and how many places both see.
    fn largest_change(&self, next: &Self) -> (f64, usize) {
        let changes: Vec<f64> = self
            .0
            .iter()
            .zip(&next.0)
            .filter_map(|(a, b)| Some(((*b)? - (*a)?).abs().max_element()))
            .collect();
        (changes.iter().copied().fold(0.0, f64::max), changes.len())
    }
}

/// Largest change of a place between the views of consecutive cameras, and that from the first to
/// the last.
fn largest_changes(
    renderer: &mut Renderer,
    street: &Street,
    cameras: impl Iterator<Item = PosedCamera>,
) -> (f64, f64) {
    let looks: Vec<Look> = cameras.map(|camera| Look::at(renderer, street, camera)).collect();
    let mut largest = 0.0f64;
    for (step, pair) in looks.windows(2).enumerate() {
        let (change, seen) = pair[0].largest_change(&pair[1]);
        assert!(seen > 100, "step {step}: {seen} places");
        largest = largest.max(change);
    }
    (largest, looks[0].largest_change(&looks[looks.len() - 1]).0)
}

/// Three of nine rigs colour a frame. The walk goes along the rigs' line, through the centre of
/// one, past others, and over boundaries where a rig leaves the set and another enters it.
#[test]
fn walking_changes_colours_little_by_little() {
    let at = |step: u32| {
        let y = -0.95 + 0.01 * f64::from(step);
        camera(ORIGIN, [-0.9, y, 2.0], 90.0, 3.0, 60.0, SIZE)
    };
    for (exposed, points, gains) in [
        (Exposed::Nothing, true, false),
        (Exposed::Rigs, false, false),
        (Exposed::Rigs, true, true),
    ] {
        let (street, mut renderer) = scene(exposed, points, gains);
        let (largest, whole) = largest_changes(&mut renderer, &street, (0..105).map(at));
        let allowed = match (exposed, gains) {
            (Exposed::Nothing, _) => STEP_255,
            (_, false) => EXPOSED_STEP_255,
            (_, true) => GAINS_STEP_255,
        };
        assert!(largest < allowed, "{exposed:?} {points} {gains}: {largest}");
        let differs = exposed != Exposed::Nothing;
        assert!(gains || (whole > 20.0) == differs, "what the walk changes in all: {whole}");
    }
}

/// Which rigs colour a frame depends on where the eye is, not on where it looks.
#[test]
fn turning_the_head_changes_no_colour() {
    let at = |step: u32| {
        let heading = 75.0 + 2.3 * f64::from(step);
        // Finer than what fades at the photographs' borders.
        camera(ORIGIN, [-0.8, 0.4, 2.0], heading, 3.0, 60.0, 4 * SIZE)
    };
    for points in [false, true] {
        let (street, mut renderer) = scene(Exposed::Rigs, points, false);
        let (largest, _) = largest_changes(&mut renderer, &street, (0..9).map(at));
        assert!(largest < STEP_255, "points {points}: {largest}");
    }
}

/// The picture is as bright as the photographs that see something of the view: as the head turns to
/// those of other cameras, it goes there little by little, both ways.
#[test]
fn turning_to_darker_photographs_changes_brightness_little_by_little() {
    let at = |step: u32| {
        let heading = 78.0 - 2.3 * f64::from(step.abs_diff(11));
        camera(ORIGIN, [-0.8, 0.4, 2.0], heading, 3.0, 60.0, SIZE)
    };
    let (street, mut renderer) = scene(Exposed::Cameras, false, true);
    let (largest, _) = largest_changes(&mut renderer, &street, (0..23).map(at));
    assert!(largest < GAINS_STEP_255, "{largest}");
    let (_, whole) = largest_changes(&mut renderer, &street, [11, 0].map(at).into_iter());
    assert!(whole > 5.0, "it makes no difference what is seen: {whole}");
}

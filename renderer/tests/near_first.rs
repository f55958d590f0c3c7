//! What a survey measured near the eye goes before what it measured of the same places from
//! elsewhere.

mod common;

use common::*;
use flaneur_renderer::{Frame, Mode, RenderError, Renderer, Settings};
use flaneur_scene::{NodeKey, PointChunk, PointNodeId, PointStations, View};
use glam::{DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(120, 90);
const ORIGIN: DVec3 = DVec3::new(651_000.0, 6_861_000.0, 40.0);
/// Of the two copies of a wall.
const COLOURS: [[u8; 3]; 2] = [[250, 0, 0], [0, 0, 250]];
/// Half the length of the way that the survey took along the y axis, in places a metre apart.
const REACH: i32 = 20;

/// A wall across the east, taken twice: the copies lie at x = 6 m and, before it, at 5.85 m.
/// `station`: whence a copy's points at some y were taken.
fn wall(station: impl Fn(usize, f64) -> f64) -> Vec<PointChunk> {
    let place = |y: f64| DVec3::new(0.0, y, 1.8);
    let places = (-REACH..=REACH).map(|y| ORIGIN + place(f64::from(y))).collect();
    let mut stations = PointStations { places, of_points: Vec::new() };
    let index = |y: f64| (y.round() as i32 + REACH).clamp(0, 2 * REACH) as u16;
    let chunk = |copy: usize| {
        let x = [6.0f32, 5.85][copy];
        // In columns of 64, so that a block has four of them.
        let at = |i: u16| [x, f32::from(i / 64) * 0.06 - 12.0, f32::from(i % 64) * 0.06];
        let positions: Vec<[f32; 3]> = (0..64 * 400).map(at).collect();
        stations.of_points =
            positions.iter().map(|&[_, y, _]| index(station(copy, y.into()))).collect();
        PointChunk {
            id: PointNodeId { source: 0, key: NodeKey { level: 1, x: copy as u32, y: 0, z: 0 } },
            origin: ORIGIN,
            colours: vec![COLOURS[copy]; positions.len()],
            positions,
            intensities: Vec::new(),
            classes: Vec::new(),
            normals: Vec::new(),
            stations: stations.clone(),
            spacing_m: 0.06,
            spacings_m: Vec::new(),
        }
    };
    [0, 1].map(chunk).into()
}

fn renderer_of(chunks: Vec<PointChunk>, near_first: bool) -> Renderer {
    let settings = Settings { near_first, ..Settings::default() };
    renderer(settings, chunks.into_iter().map(points_update).collect())
}

fn seen(renderer: &mut Renderer, y: f64) -> Frame {
    let view = View::from(camera(ORIGIN, [0.0, y, 1.8], 90.0, 0.0, 60.0, SIZE));
    renderer.render_as(&view, Mode::PointsColour).expect("a frame")
}

/// How many pixels show each copy.
fn pixels_of(frame: &Frame) -> [usize; 2] {
    let shows = |colour: &[u8; 3]| {
        frame.rgba.chunks_exact(4).filter(|pixel| pixel[..3] == colour[..]).count()
    };
    COLOURS.each_ref().map(shows)
}

#[test]
fn the_copy_that_was_taken_near_the_eye_is_seen() {
    let from_the_ends = |copy: usize, _: f64| [-9.0, 9.0][copy];
    let mut near_first = renderer_of(wall(from_the_ends), true);
    let mut alike = renderer_of(wall(from_the_ends), false);
    for (y, copy) in [(-9.0, 0), (-5.0, 0), (5.0, 1), (9.0, 1)] {
        let pixels = pixels_of(&seen(&mut near_first, y));
        // Seen over the other one's top, the nearer copy is a row or two higher.
        assert!(pixels[copy] > 4000 && pixels[1 - copy] <= 3 * SIZE.x as usize, "{y}: {pixels:?}");
        let pixels = pixels_of(&seen(&mut alike, y));
        assert!(pixels[1] > 4000 && pixels[0] == 0, "{y}, all alike: {pixels:?}");
    }
}

/// Where nothing was measured nearby, the rest is seen as before.
#[test]
fn what_was_taken_elsewhere_closes_gaps() {
    let mut chunks = wall(|copy, _| [-9.0, 9.0][copy]);
    let half = chunks[0].positions.len() / 2;
    chunks[0].positions.truncate(half);
    chunks[0].colours.truncate(half);
    chunks[0].stations.of_points.truncate(half);
    let mut renderer = renderer_of(chunks, true);
    let frame = seen(&mut renderer, -1.0);
    let [near, far] = pixels_of(&frame);
    assert!(near > 1000 && far > 1000, "{near} {far}");
    let whole = pixels_of(&seen(&mut renderer_of(wall(|_, _| 0.0), true), -1.0));
    assert!(near + far + 50 > whole[0] + whole[1], "{near} {far} of {whole:?}");
}

/// One drive measures abreast, the other one 4 m later: what of the wall is shown by which moves
/// along with the eye, instead of changing at once.
#[test]
fn walking_changes_a_little_at_a_time() {
    let mut renderer = renderer_of(wall(|copy, y| [y, y + 4.0][copy]), true);
    let mut look = |step: u32| {
        let frame = seen(&mut renderer, -3.0 + 0.05 * f64::from(step));
        (pixels_of(&frame), frame)
    };
    let (mut before, _) = look(0);
    let mut largest = 0;
    for step in 1..80 {
        let (now, frame) = look(step);
        assert!(now[0] > 500 && now[1] > 500, "{now:?} of {}", frame.stats.geometry_pixels);
        largest = largest.max(now[0].abs_diff(before[0]));
        before = now;
    }
    // A run of points is four columns of 6 cm, of 7 m and 120 pixels.
    let run = (SIZE.x * SIZE.y) as usize * 24 / 700;
    assert!(largest <= 2 * run, "{largest} pixels at once, of {run} a run");
}

/// Without stations, or where none is known, the picture is bit for bit that of points alike.
#[test]
fn points_without_stations_are_alike() {
    let known = wall(|_, _| 0.0);
    let with = |stations: &dyn Fn(&PointChunk) -> PointStations| {
        known
            .iter()
            .map(|chunk| PointChunk { stations: stations(chunk), ..chunk.clone() })
            .collect()
    };
    let none: Vec<PointChunk> = with(&|_| PointStations::default());
    let unknown: Vec<PointChunk> = with(&|chunk| PointStations {
        of_points: vec![PointStations::UNKNOWN; chunk.positions.len()],
        ..chunk.stations.clone()
    });
    let mut alike = renderer_of(known.clone(), false);
    for chunks in [none, unknown] {
        let mut renderer = renderer_of(chunks, true);
        for y in [-9.0, 0.3, 14.0] {
            assert!(seen(&mut renderer, y) == seen(&mut alike, y), "{y}");
        }
    }
}

#[test]
fn stations_that_make_no_sense_are_refused() {
    let good = wall(|_, _| 0.0).swap_remove(0);
    let refused = |change: &dyn Fn(&mut PointStations)| {
        let mut chunk = good.clone();
        change(&mut chunk.stations);
        let mut renderer = renderer_of(Vec::new(), true);
        renderer.apply(points_update(chunk)).expect_err("nonsense")
    };
    let beyond = refused(&|stations| stations.of_points[7] = 2 * REACH as u16 + 1);
    assert!(matches!(beyond, RenderError::PointStations { .. }), "{beyond}");
    let nowhere = refused(&|stations| stations.places = [DVec3::NAN, DVec3::ZERO].into());
    assert!(matches!(nowhere, RenderError::PointStations { .. }), "{nowhere}");
    let short = refused(&|stations| stations.of_points.truncate(9));
    assert!(matches!(short, RenderError::PointColumns { column: "stations", .. }), "{short}");
}

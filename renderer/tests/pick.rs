//! What a pixel of a picture shows, against what is known of the street.

mod common;

use common::*;
use flaneur_renderer::{Picked, PickedSurface, Settings};
use flaneur_scene::{SceneUpdate, SurfaceClass, View};
use glam::{DVec2, DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(320, 200);
const PHOTO: UVec2 = UVec2::new(640, 480);
/// Northings of Lambert-93.
const FAR: DVec3 = DVec3::new(651_000.0, 6_861_000.0, 40.0);

fn view() -> View {
    View::from(camera(FAR, [-1.0, 0.0, 1.8], 80.0, 3.0, 70.0, SIZE))
}

/// Three photographs: `near` sees the wall, from `aside` the pole hides a part of it, and what `masked`
/// sees right of its middle is no scene.
fn photographs(street: &Street) -> Vec<SceneUpdate> {
    let taken = |id: &str, at: [f64; 3], heading: f64| {
        street.photograph(id, camera(FAR, at, heading, 5.0, 80.0, PHOTO))
    };
    let mut masked = taken("masked/x", [-0.5, -1.0, 1.6], 90.0);
    for (x, pixel) in (0..PHOTO.x).cycle().zip(masked.rgba.chunks_exact_mut(4)) {
        pixel[3] = if x < PHOTO.x / 2 { 255 } else { 0 };
    }
    let photographs =
        [taken("near/x", [-0.5, 0.5, 1.7], 85.0), taken("aside/x", [0.0, 4.0, 1.7], 100.0), masked];
    photographs.into_iter().map(image_update).collect()
}

/// What each of some pixels shows, and what it should.
fn picked(updates: Vec<SceneUpdate>, street: &Street) -> Vec<(Option<Picked>, Option<Hit>, DVec2)> {
    let mut renderer = renderer(Settings::default(), updates);
    renderer.render(&view()).expect("a frame");
    let truth = street.picture(&view().camera);
    pixels(SIZE)
        .enumerate()
        .filter(|(index, _)| index % 197 == 0 && is_interior(&truth, SIZE, *index, 3))
        .map(|(index, pixel)| {
            // Off the centre of the pixel, where no record is.
            let pixel = pixel + DVec2::new(0.3, -0.2);
            let ray = view().ray(pixel).expect("a pinhole");
            let hit = truth[index].and_then(|_| street.trace(ray.origin - FAR, ray.direction));
            (renderer.pick(pixel).expect("a driver"), hit, pixel)
        })
        .collect()
}

#[test]
fn a_mesh_is_where_it_is_and_seen_by_those_who_see_it() {
    let street = Street::with_pole(FAR);
    let objects: Vec<usize> = (0..=street.blocks.len()).collect();
    let photographs = photographs(&street);
    let cameras: Vec<_> = photographs
        .iter()
        .filter_map(|update| match update {
            SceneUpdate::Image(image) => Some((image.id.clone(), image.camera)),
            _ => None,
        })
        .collect();
    let mut updates = vec![mesh_update(street.mesh(&objects, 0.25))];
    updates.extend(photographs);
    let (mut seen, mut hidden, mut masked) = (0, 0, 0);
    for (picked, hit, pixel) in picked(updates, &street) {
        let Some(hit) = hit else {
            assert_eq!(picked, None, "the sky at {pixel}");
            continue;
        };
        let picked = picked.expect("a surface");
        let error_m = picked.position.distance(FAR + hit.position);
        // A millimetre at 50 m.
        assert!(error_m < tolerances::DEPTH_M * (hit.distance / 50.0).max(0.1), "{error_m} m");
        assert!(picked.normal.angle_between(hit.normal) < 2.0 * tolerances::UNIT_VECTOR_RAD);
        assert!((picked.uncertainty_m - 0.25).abs() < 1e-3, "{picked:?}");
        let class = match hit.normal.z {
            0.0 => SurfaceClass::Wall,
            _ if hit.object == street.blocks.len() => SurfaceClass::Ground,
            _ => SurfaceClass::Roof,
        };
        assert_eq!(picked.surface, PickedSurface::Mesh(class));

        let shares: f64 = picked.seen_by.iter().map(|sight| sight.share).sum();
        assert!(picked.seen_by.is_empty() || (shares - 1.0).abs() < 1e-9, "{picked:?}");
        for (id, camera) in &cameras {
            let sight = picked.seen_by.iter().find(|sight| sight.id == *id);
            let projected = camera.project(picked.position);
            let inside = projected.filter(|(at, _)| {
                at.cmpgt(DVec2::splat(2.0)).all()
                    && (camera.lens.size.as_dvec2() - *at).cmpgt(DVec2::splat(2.0)).all()
            });
            let Some((at, _)) = inside else {
                continue;
            };
            if let Some(sight) = sight {
                assert!(sight.pixel.distance(at) < 1e-6, "{sight:?} {at}");
                let distance_m = camera.centre.distance(picked.position);
                assert!((sight.distance_m - distance_m).abs() < 1e-9);
            }
            // The truth: what a ray from the camera meets, away from edges.
            let toward = hit.position + FAR - camera.centre;
            let sees = |target: DVec3| {
                let from = camera.centre - FAR;
                let direction = (target - from).normalize();
                let first = street.trace(from, direction);
                first.is_some_and(|first| first.distance > (target - from).length() - 0.3)
            };
            let side = toward.cross(DVec3::Z).normalize() * 0.15;
            let around = [DVec3::ZERO, side, -side].map(|aside| sees(hit.position + aside));
            let is_masked = id.panorama() == "masked" && at.x > f64::from(PHOTO.x / 2) + 1.0;
            let near_mask =
                id.panorama() == "masked" && !is_masked && at.x > f64::from(PHOTO.x / 2) - 1.0;
            let grazing = hit.normal.dot(-toward.normalize()) < 0.15;
            if is_masked {
                assert!(sight.is_none(), "{id} at {pixel}");
                masked += 1;
            } else if around == [false; 3] {
                assert!(sight.is_none(), "{id} at {pixel}");
                hidden += 1;
            } else if around == [true; 3] && !near_mask && !grazing {
                assert!(sight.is_some(), "{id} at {pixel} {picked:?}");
                seen += 1;
            }
        }
    }
    assert!(seen > 100 && hidden > 5 && masked > 20, "{seen} {hidden} {masked}");
}

#[test]
fn points_are_where_they_are() {
    let street = Street::with_pole(FAR);
    let spacing_m = 0.05;
    let updates = vec![points_update(street.points(&[0], spacing_m))];
    // Radii are kept in eighths of an octave.
    let radius_m = f64::from(Settings::default().splat_scale) * spacing_m * 2f64.powf(1.0 / 16.0);
    let mut count = 0;
    for (picked, hit, pixel) in picked(updates, &street) {
        let Some(hit) = hit.filter(|hit| hit.object == 0) else { continue };
        let Some(picked) = picked else { continue };
        assert_eq!(picked.surface, PickedSurface::Point);
        // On the ray, at most as far from the wall as the edge of a disc that faces the eye.
        let off_m = (picked.position - FAR - hit.position).length();
        let direction = view().ray(pixel).expect("a pinhole").direction.normalize();
        let slope = hit.normal.angle_between(-direction).tan();
        // Discs reach the centre of a pixel that they touch, and the place is beside it.
        let reach_m = radius_m + 1.0 / view().pixels_a_metre(hit.distance);
        assert!(off_m < reach_m * slope + tolerances::DEPTH_M, "{off_m} m, slope {slope}");
        count += 1;
    }
    assert!(count > 30, "{count}");
}

/// Of a rig's cameras the one speaks that the place is furthest inside of. What its mask hides no other
/// of the rig says, neither in the picture nor in what is told of it.
#[test]
fn shares_are_those_of_the_picture() {
    let street = Street::with_pole(FAR);
    let painted = |id: &str, y: f64, heading: f64, rgba: [u8; 4]| {
        let camera = camera(FAR, [-0.8, y, 1.8], heading, 0.0, 80.0, PHOTO);
        let mut image = street.photograph(id, camera);
        image.rgba = rgba.repeat((PHOTO.x * PHOTO.y) as usize);
        image_update(image)
    };
    let updates = vec![
        mesh_update(street.mesh(&[0], 0.0)),
        painted("near/hidden", 0.2, 70.0, [200, 20, 20, 0]),
        painted("near/aside", -0.2, 110.0, [20, 200, 20, 255]),
        painted("far/x", -2.0, 90.0, [20, 20, 200, 255]),
    ];
    let settings = Settings { exposure_gains: false, align: false, ..Settings::default() };
    let mut renderer = renderer(settings, updates);
    let view = View::from(camera(FAR, [-1.0, 0.0, 1.8], 90.0, 0.0, 28.0, SIZE));
    let frame = renderer.render(&view).expect("a frame");
    let mut decided = [0, 0];
    for pixel in pixels(SIZE).step_by(97) {
        let Some(picked) = renderer.pick(pixel).expect("a driver") else { continue };
        let share = |id: &str| {
            let sight = picked.seen_by.iter().find(|sight| sight.id.to_string() == id);
            sight.map(|sight| sight.share)
        };
        assert_eq!(share("near/hidden"), None, "what a mask hides is not seen");
        let (aside, far) =
            (share("near/aside").expect("it sees"), share("far/x").expect("it sees"));
        assert!((aside + far - 1.0).abs() < 1e-9, "{aside} {far}");
        let index = pixel.as_uvec2();
        let rgb = &frame.rgba[4 * (index.y * SIZE.x + index.x) as usize..];
        if aside == 0.0 {
            assert_eq!(rgb[..3], [20, 20, 200], "{pixel}");
        } else {
            assert!(rgb[1] > rgb[2], "the nearer counts more at {pixel}: {rgb:?}", rgb = &rgb[..3]);
        }
        decided[usize::from(aside > 0.0)] += 1;
    }
    assert!(decided.iter().all(|count| *count > 20), "{decided:?}");
}

/// Points arrive between a frame and a pick: depth maps that the pick draws have them, and the frames
/// after it.
#[test]
fn what_comes_between_frame_and_pick_counts() {
    let street = Street::with_pole(FAR);
    let frame_after = |picks: bool| {
        let mut updates = vec![mesh_update(street.mesh(&[0, street.blocks.len()], 0.25))];
        updates.extend(photographs(&street));
        let mut renderer = renderer(Settings::default(), updates);
        renderer.render(&view()).expect("a frame");
        // A pole that hides the wall from one of the photographs.
        renderer.apply(points_update(street.points(&[1], 0.04))).expect("good points");
        if picks {
            renderer.pick(0.5 * SIZE.as_dvec2()).expect("a driver").expect("a surface");
        }
        renderer.render(&view()).expect("a frame").rgba
    };
    assert!(frame_after(true) == frame_after(false), "a pick changes the frames after it");
}

#[test]
fn nothing_is_picked_where_there_is_no_picture() {
    let street = Street::with_pole(FAR);
    let mut renderer = renderer(Settings::default(), vec![mesh_update(street.mesh(&[0], 0.0))]);
    assert_eq!(renderer.pick(DVec2::ONE).expect("a driver"), None, "no frame yet");
    renderer.render(&view()).expect("a frame");
    for beyond in [DVec2::new(-1.0, 5.0), DVec2::new(5.0, 200.0), DVec2::NAN, DVec2::INFINITY] {
        assert_eq!(renderer.pick(beyond).expect("a driver"), None, "{beyond}");
    }
}

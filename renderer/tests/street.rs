//! Whole frames of a street that is known exactly.

mod common;

use std::collections::BTreeMap;

use common::*;
use flaneur_renderer::{Frame, Mode, Settings, Surface};
use flaneur_scene::{
    Distortion, Intrinsics, Lens, PosedCamera, SceneUpdate, View, srgb_from_linear,
};
use glam::{DVec2, DVec3, IVec2, UVec2, Vec3};
use tolerances::{
    DEPTH_MODE_255, ELEVATION_WRONG_SHARE, FAR_AWAY_255, FILTERED_255, OWN_PHOTOGRAPH_MEAN_255,
    POLE_WRONG_SHARE, RESAMPLED_255, RESAMPLED_MEAN_255, SMEARED_SHARE,
};

const SIZE: UVec2 = UVec2::new(320, 240);
const PHOTO: UVec2 = UVec2::new(640, 480);

/// Where the street is looked at from: none of the photographs' places.
fn view(origin: DVec3) -> View {
    View::from(camera(origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE))
}

fn photo_camera(origin: DVec3, at: [f64; 3], heading: f64) -> PosedCamera {
    camera(origin, at, heading, 5.0, 70.0, PHOTO)
}

/// Photographs looking at the wall from two places.
fn photographs(street: &Street) -> Vec<SceneUpdate> {
    let at = |place, heading| photo_camera(street.origin, place, heading);
    vec![
        image_update(street.photograph("a/east", at([-1.0, -3.0, 2.0], 80.0))),
        image_update(street.photograph("b/east", at([-0.5, 4.0, 2.2], 100.0))),
    ]
}

/// All surfaces as mesh, and the photographs.
fn meshed(street: &Street) -> Vec<SceneUpdate> {
    let everything: Vec<usize> = (0..=street.blocks.len()).collect();
    let mut updates = photographs(street);
    updates.push(mesh_update(street.mesh(&everything, 0.0)));
    updates
}

#[test]
fn mesh_and_photographs_give_the_picture_of_another_place() {
    let street = Street::with_pole(DVec3::ZERO);
    let view = view(street.origin);
    let frame = renderer(Settings::default(), meshed(&street)).render(&view).expect("a frame");
    keep(&frame, "mesh");
    assert_eq!((frame.stats.images, frame.stats.images_drawn), (2, 2));
    let truth = street.picture(&view.camera);
    for (i, seen) in truth.iter().enumerate() {
        if is_interior(&truth, SIZE, i, 1) {
            assert_eq!(frame.surfaces[i].is_geometry(), seen.is_some(), "pixel {i}");
        }
    }
    street.likeness(&frame, &view.camera, 2).assert_resampled(60_000);
    let [geometry, coloured] = [Surface::is_geometry, Surface::is_coloured]
        .map(|test| frame.surfaces.iter().filter(|surface| test(**surface)).count() as u64);
    assert_eq!(frame.stats.geometry_pixels, geometry);
    assert_eq!(frame.stats.coloured_pixels, coloured);
    assert!(frame.stats.coverage() > 0.9 && frame.stats.coverage() < 1.0);
    assert!(frame.rgba.iter().skip(3).step_by(4).all(|&alpha| alpha == 255));
}

/// The pole is known from points alone. Its picture must not be smeared on the wall behind.
#[test]
fn a_pole_of_points_hides_the_wall_and_is_not_smeared_on_it() {
    let street = Street::with_pole(DVec3::ZERO);
    let view = view(street.origin);
    let mesh = mesh_update(street.mesh(&[0, 2, 3], 0.0));
    let mut updates = photographs(&street);
    updates.push(mesh);
    let without = renderer(Settings::default(), updates.clone()).render(&view).expect("a frame");
    updates.push(points_update(street.points(&[1], 0.03)));
    let with = renderer(Settings::default(), updates).render(&view).expect("a frame");
    keep(&with, "pole");
    // Points of the pole stand for its surface within the radius of a disc.
    let likeness = street.likeness(&with, &view.camera, 4);
    assert!(
        likeness.wrong < POLE_WRONG_SHARE && likeness.mean < RESAMPLED_MEAN_255,
        "{likeness:?}"
    );
    let smeared = street.likeness(&without, &view.camera, 4);
    assert!(smeared.wrong > SMEARED_SHARE, "the test sees smearing: {smeared:?}");
    let truth = street.picture(&view.camera);
    for (i, seen) in truth.iter().enumerate() {
        if seen.is_some_and(|(hit, _)| hit.object == 1) && is_interior(&truth, SIZE, i, 3) {
            let point = [Surface::PointColoured, Surface::PointUncoloured];
            assert!(point.contains(&with.surfaces[i]), "pole at {i}: {:?}", with.surfaces[i]);
        }
    }
}

/// The mesh does not know the pole. Where the depth maps are not told of its points, or are not
/// asked, it is smeared on the wall behind.
#[test]
fn without_the_depth_test_or_its_refinement_the_pole_is_smeared() {
    let street = Street::with_pole(DVec3::ZERO);
    let view = view(street.origin);
    let mut updates = photographs(&street);
    updates.push(mesh_update(street.mesh(&[0, 2, 3], 0.0)));
    updates.push(points_update(street.points(&[1], 0.03)));
    let wrong = |settings| {
        let frame = renderer(settings, updates.clone()).render(&view).expect("a frame");
        street.likeness(&frame, &view.camera, 4).wrong
    };
    // Without the pole photographs do not agree, and gains cannot make them.
    // Alone: what is smeared may be aligned, too.
    let settings = Settings { align: false, exposure_gains: false, ..Settings::default() };
    let whole = wrong(settings);
    let blind = wrong(Settings { depth_test: false, ..settings });
    let coarse = wrong(Settings { refine_by_points: false, ..settings });
    // Between two frames, too.
    let mut changing = renderer(settings, updates.clone());
    let mut render = |changed| {
        assert!(changing.set_settings(changed), "{changed:?}");
        street.likeness(&changing.render(&view).expect("a frame"), &view.camera, 4).wrong
    };
    assert_eq!(render(Settings { depth_test: false, ..settings }), blind);
    assert_eq!(render(Settings { refine_by_points: false, ..settings }), coarse);
    assert_eq!(render(settings), whole);
    println!("wrong pixels: {whole:.4}, without refinement {coarse:.4}, without test {blind:.4}");
    assert!(
        whole < POLE_WRONG_SHARE && coarse > SMEARED_SHARE && blind >= coarse,
        "{whole} {coarse} {blind}"
    );
}

/// The mesh puts the wall 0.3 m behind or before its true place, and knows that it may be off
/// by 0.5 m: the points replace it. With δ = 0.1 m those behind it stay hidden.
#[test]
fn points_within_its_uncertainty_replace_the_wall() {
    let street = Street::with_pole(DVec3::ZERO);
    let view = view(street.origin);
    for (shift, uncertainty_m, replaced) in
        [(0.3, 0.5, true), (-0.3, 0.5, true), (-0.3, 0.1, false)]
    {
        let mut wrong = street.clone();
        wrong.blocks[0].min.x += shift;
        let mut updates = photographs(&street);
        updates.push(mesh_update(wrong.mesh(&[0], uncertainty_m)));
        updates.push(points_update(street.points(&[0], 0.04)));
        let frame = renderer(Settings::default(), updates).render(&view).expect("a frame");
        keep(&frame, &format!("wall{shift}-{uncertainty_m}"));
        let truth = street.picture(&view.camera);
        let (mut points, mut wall) = (0, 0);
        for (i, seen) in truth.iter().enumerate() {
            if seen.is_some_and(|(hit, _)| hit.object == 0) && is_interior(&truth, SIZE, i, 3) {
                wall += 1;
                points += u32::from(matches!(
                    frame.surfaces[i],
                    Surface::PointColoured | Surface::PointUncoloured
                ));
            }
        }
        let share = f64::from(points) / f64::from(wall);
        assert!(if replaced { share > 0.99 } else { share < 0.01 }, "{shift}: {share}");
    }
}

/// A view with the lens of a photograph: straight walls bend as they do in photographs.
#[test]
fn a_distorted_view_shows_the_street_through_its_lens() {
    let street = Street::with_pole(DVec3::ZERO);
    let intrinsics = Intrinsics { fx: 180.0, fy: 175.0, cx: 164.0, cy: 117.0 };
    for distortion in DISTORTIONS {
        let lens = Lens { size: SIZE, intrinsics, distortion };
        let view = View::from(with_lens(view(street.origin).camera, lens));
        let frame = renderer(Settings::default(), meshed(&street)).render(&view).expect("a frame");
        keep(&frame, "distorted");
        let truth = street.picture(&view.camera);
        for (i, seen) in truth.iter().enumerate() {
            if is_interior(&truth, SIZE, i, 2) {
                assert_eq!(frame.surfaces[i].is_geometry(), seen.is_some(), "{distortion:?} {i}");
            }
        }
        street.likeness(&frame, &view.camera, 3).assert_resampled(40_000);
    }
}

#[test]
fn far_from_the_origin_the_picture_is_the_same() {
    let frame_at = |origin: DVec3| {
        let street = Street::with_pole(origin);
        let mut updates = meshed(&street);
        updates.push(points_update(street.points(&[1], 0.05)));
        renderer(Settings::default(), updates).render(&view(origin)).expect("a frame")
    };
    let here = frame_at(DVec3::ZERO);
    for origin in [DVec3::new(651_000.0, 6_861_000.0, 40.0), DVec3::splat(1e8)] {
        let there = frame_at(origin);
        let different = here
            .rgba
            .chunks_exact(4)
            .zip(there.rgba.chunks_exact(4))
            .filter(|(a, b)| {
                a.iter().zip(*b).any(|(a, b)| f64::from(a.abs_diff(*b)) > FAR_AWAY_255)
            })
            .count();
        assert!(different * 1000 < here.surfaces.len(), "{origin}: {different} pixels");
    }
}

/// With other photographs about, the one whose centre the eye is at is what is seen.
#[test]
fn from_its_own_centre_a_photograph_is_itself() {
    let street = Street::with_pole(DVec3::ZERO);
    let own = photo_camera(street.origin, [-1.0, -3.0, 2.0], 80.0);
    let photograph = street.photograph("a/east", own);
    let brown = Distortion::Brown { k: [-0.1, 0.02, 0.0], p: [0.002, 0.001] };
    let bent = with_lens(own, Lens { distortion: brown, ..own.lens });
    for camera in [own, bent] {
        let photograph =
            if camera == own { photograph.clone() } else { street.photograph("a/east", camera) };
        let mut updates = meshed(&street);
        updates.push(image_update(photograph.clone()));
        let frame =
            renderer(Settings::default(), updates).render(&View::from(camera)).expect("a frame");
        keep(&frame, "own");
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, surface) in frame.surfaces.iter().enumerate() {
            if surface.is_geometry() {
                let bytes = &photograph.rgba[4 * i..4 * i + 3];
                let truth = DVec3::new(bytes[0].into(), bytes[1].into(), bytes[2].into()) / 255.0;
                sum += difference(&frame.rgba, i, truth);
                count += 1.0;
            }
        }
        let mean: f64 = sum / count;
        assert!(count > 200_000.0 && mean < OWN_PHOTOGRAPH_MEAN_255, "{mean} over {count}");
    }
}

/// What the mask excludes may have any colour: the picture is the same.
#[test]
fn masked_pixels_are_never_used() {
    let street = Street::with_pole(DVec3::ZERO);
    let frame = |paint: [u8; 4], size: UVec2| {
        let masked = |id: &str, place, heading| {
            let camera = photo_camera(street.origin, place, heading);
            let mut image = street.photograph(id, camera);
            // A board of 40 x 40 pixels.
            for (i, pixel) in image.rgba.chunks_exact_mut(4).enumerate() {
                if (i / 40 + i / 25_600).is_multiple_of(2) {
                    pixel.copy_from_slice(&paint);
                }
            }
            image_update(image)
        };
        let updates = vec![
            mesh_update(street.mesh(&[0, 1, 2, 3], 0.0)),
            masked("a/east", [-1.0, -3.0, 2.0], 80.0),
            masked("b/east", [-0.5, 4.0, 2.2], 100.0),
        ];
        let camera = camera(street.origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, size);
        renderer(Settings::default(), updates).render(&View::from(camera)).expect("a frame")
    };
    // The small view looks at coarser levels of detail.
    for size in [SIZE, UVec2::new(80, 60)] {
        let red = frame([255, 0, 0, 0], size);
        let green = frame([0, 255, 0, 0], size);
        keep(&red, "masked");
        let coverage = red.stats.coverage();
        assert!(coverage > 0.1 && coverage < 0.95, "{coverage}");
        assert!(red.surfaces == green.surfaces);
        // Filtering weighs texels in 256ths: what is less than that may still round a byte.
        let off = red.rgba.iter().zip(&green.rgba).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off.is_some_and(|off| f64::from(off) <= FILTERED_255), "{size}: {off:?}");
    }
}

/// A lens that folds back on itself inside its own picture: what lies beyond is not coloured
/// by the mirrored picture.
#[test]
fn a_folding_lens_colours_nothing_beyond_its_limit() {
    let street = Street::with_pole(DVec3::ZERO);
    let pinhole = photo_camera(street.origin, [-1.0, -3.0, 2.0], 80.0);
    let distortion = Distortion::Brown { k: [-1.2, 0.0, 0.0], p: [0.0; 2] };
    let lens = Lens { distortion, ..pinhole.lens };
    let camera = with_lens(pinhole, lens);
    let limit = distortion.limit();
    let updates = vec![
        mesh_update(street.mesh(&[0, 1, 2, 3], 0.0)),
        image_update(street.photograph("a/east", camera)),
    ];
    let view = view(street.origin);
    let frame = renderer(Settings::default(), updates).render(&view).expect("a frame");
    keep(&frame, "folding");
    let truth = street.picture(&view.camera);
    let (mut beyond, mut within) = (0, 0);
    for (i, seen) in truth.iter().enumerate() {
        let Some((hit, _)) = seen.filter(|_| is_interior(&truth, SIZE, i, 2)) else { continue };
        let c = camera.cam_from_world(hit.position + street.origin);
        let radius = (c.truncate() / c.z).length();
        if c.z < 0.0 || radius > limit * 1.001 {
            assert!(!frame.surfaces[i].is_coloured(), "pixel {i}, radius {radius} of {limit}");
            beyond += 1;
        } else {
            within += u32::from(frame.surfaces[i].is_coloured());
        }
    }
    assert!(beyond > 5000 && within > 5000, "{beyond} beyond, {within} within");
}

/// Walls keep their size however far they are: an elevation of the street.
#[test]
fn an_orthographic_view_shows_the_street_to_scale() {
    let street = Street::with_pole(DVec3::new(651_000.0, 6_861_000.0, 40.0));
    let eye = street.origin + DVec3::new(-3.0, 0.0, 4.5);
    // 9 m high, 12 m wide: the wall from y = 6 on the left to y = -6 on the right.
    let view = View::orthographic(eye, 90f64.to_radians(), 0.0, 9.0, SIZE);
    let mut updates = meshed(&street);
    updates.push(points_update(street.points(&[1], 0.02)));
    let frame = renderer(Settings::default(), updates).render(&view).expect("a frame");
    keep(&frame, "orthographic");
    let (mut compared, mut wrong, mut off) = (0, 0, 0.0);
    let trace = |pixel: DVec2| {
        let ray = view.ray(pixel).expect("a ray");
        street.trace(ray.origin - street.origin, ray.direction)
    };
    for (i, pixel) in pixels(SIZE).enumerate() {
        let hit = trace(pixel).expect("the wall fills the picture");
        // Not beside the pole, nor beside the shadows that it has in the photographs.
        let near = [-2.0, 2.0].map(|dx| trace(pixel + DVec2::new(dx, 0.0)).map(|hit| hit.object));
        if !frame.surfaces[i].is_coloured() || near != [Some(hit.object); 2] {
            continue;
        }
        let truth = DVec3::from(street.paint(&hit).to_array().map(srgb_from_linear));
        let difference = difference(&frame.rgba, i, truth);
        compared += 1;
        off += difference;
        wrong += u32::from(difference > RESAMPLED_255);
    }
    let wrong = f64::from(wrong) / f64::from(compared);
    assert!(compared > 60_000 && wrong < ELEVATION_WRONG_SHARE, "{compared} {wrong}");
    assert!(off / f64::from(compared) < RESAMPLED_MEAN_255, "{off}");
}

/// Every mode draws, and none but the photographs' own changes which pixels have geometry.
#[test]
fn modes_show_the_same_scene_in_their_own_way() {
    let street = Street::with_pole(DVec3::ZERO);
    let view = view(street.origin);
    let mut updates = photographs(&street);
    updates.push(mesh_update(street.mesh(&[0, 2, 3], 0.0)));
    updates.push(points_update(street.points(&[1], 0.03)));
    let mut renderer = renderer(Settings::default(), updates);
    let hybrid = renderer.render(&view).expect("a frame");
    let shows = |frame: &Frame, kinds: [Surface; 2]| {
        frame.surfaces.iter().filter(|surface| kinds.contains(surface)).count()
    };
    let (mesh, point) = (
        [Surface::MeshColoured, Surface::MeshUncoloured],
        [Surface::PointColoured, Surface::PointUncoloured],
    );
    for mode in Mode::ALL {
        let frame = renderer.render_as(&view, mode).expect("a frame");
        keep(&frame, mode.name());
        assert_eq!(mode.name().parse(), Ok(mode));
        assert_eq!(frame == hybrid, mode == Mode::Hybrid, "{mode:?}");
        let (meshes, points) = (shows(&frame, mesh), shows(&frame, point));
        match mode {
            Mode::Mesh => assert!(points == 0 && meshes >= shows(&hybrid, mesh)),
            Mode::Points | Mode::PointsColour => {
                assert!(meshes == 0 && points >= shows(&hybrid, point));
            }
            Mode::Wireframe => assert_shows_edges(&frame, &view, &street, &[0, 2, 3]),
            Mode::Depth => {
                // 10 / (10 + depth), of the wall 6.8 m ahead of the eye.
                let truth = street.picture(&view.camera);
                for (i, seen) in truth.iter().enumerate() {
                    let Some((hit, _)) = seen else { continue };
                    if is_interior(&truth, SIZE, i, 3) {
                        let p = street.origin + hit.position;
                        let depth = view.camera.cam_from_world(p).z;
                        let expected = 255.0 * 10.0 / (10.0 + depth);
                        let found = f64::from(frame.rgba[4 * i]);
                        assert!(
                            (found - expected).abs() < DEPTH_MODE_255,
                            "{i}: {found} for {expected}"
                        );
                    }
                }
            }
            _ => assert_eq!(frame.surfaces, hybrid.surfaces, "{mode:?}"),
        }
    }
}

/// Every edge of the mesh that nothing hides is dark, to a pixel, and nothing but edges. Where walls meet the
/// ground a pixel shows one or the other.
fn assert_shows_edges(frame: &Frame, view: &View, street: &Street, meshed: &[usize]) {
    let mesh = street.mesh(meshed, 0.0);
    let is_dark = |at: IVec2| frame.rgba[4 * (at.y as u32 * SIZE.x + at.x as u32) as usize] < 20;
    let around = |at: IVec2| (0..9).map(move |i| at + IVec2::new(i % 3 - 1, i / 3 - 1));
    let inner = |at: IVec2| at.cmpgt(IVec2::ONE).all() && (at + 2).as_uvec2().cmplt(SIZE).all();
    let place = |index: u32| Vec3::from(mesh.vertices[index as usize].position).as_dvec3();
    let triangles = mesh.indices.chunks_exact(3);
    let edges = triangles.flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    let eye = view.eye() - street.origin;
    let is_seen = |place: DVec3| {
        let direction = (place - eye).normalize();
        let first = street.trace(eye, direction);
        first.is_none_or(|first| first.distance > place.distance(eye) - 0.02)
    };
    // Whether any of what falls on a pixel is seen.
    let mut on_edges: BTreeMap<[i32; 2], bool> = BTreeMap::new();
    for (a, b) in edges {
        for i in 0..=2000 {
            let on_edge = place(a).lerp(place(b), f64::from(i) / 2000.0);
            let Some((pixel, _)) = view.camera.project(street.origin + on_edge) else { continue };
            let at = pixel.floor().as_ivec2();
            if inner(at) {
                let meets_ground = place(a).z == 0.0 && place(b).z == 0.0 && on_edge.x >= 6.0;
                *on_edges.entry(at.to_array()).or_default() |= !meets_ground && is_seen(on_edge);
            }
        }
    }
    let is_mesh = |at: IVec2| {
        let shown = frame.surfaces[(at.y as u32 * SIZE.x + at.x as u32) as usize];
        matches!(shown, Surface::MeshColoured | Surface::MeshUncoloured)
    };
    let seen: Vec<IVec2> = on_edges
        .iter()
        .filter(|(_, seen)| **seen)
        .map(|(at, _)| IVec2::from(*at))
        .filter(|at| around(*at).all(is_mesh))
        .collect();
    assert!(seen.len() > 300, "{} pixels of edges", seen.len());
    for at in seen {
        assert!(around(at).any(is_dark), "an edge is missing at {at}");
    }
    for at in pixels(SIZE).map(|pixel| pixel.as_ivec2()).filter(|at| inner(*at)) {
        let beside = around(at).any(|other| on_edges.contains_key(&other.to_array()));
        assert!(!is_dark(at) || !around(at).all(inner) || beside, "there is no edge at {at}");
    }
}

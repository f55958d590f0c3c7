use super::*;
use crate::sight::Surfaces;
use flaneur_scene::{CubeFace, Intrinsics, Lens, StoredImage, world_from_rig};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

const EYE: DVec3 = DVec3::new(651_000.0, 6_861_000.0, 42.0);

fn panorama(id: &str, at: DVec3, cameras: Vec<RigCamera>) -> Arc<Panorama> {
    Arc::new(Panorama {
        id: id.into(),
        position: EYE + at,
        world_from_rig: world_from_rig(0.0, 0.0, 0.0),
        time: None,
        uncertainty_m: 0.1,
        cameras,
    })
}

fn camera(id: &str, heading: f64, side: u32) -> RigCamera {
    let size = UVec2::splat(side);
    let lens = Lens::pinhole(size, Intrinsics::from_fov_y(PI / 2.0, size));
    RigCamera {
        id: id.into(),
        position_in_rig: DVec3::ZERO,
        cam_from_rig: flaneur_scene::CUBE_FACES[0].cam_from_rig()
            * world_from_rig(heading, 0.0, 0.0).transpose(),
        projection: Projection::Pinhole(lens),
        levels: vec![StoredImage { bytes: 1, crc32: 0 }; 6],
        mask: None,
        version: "1".into(),
    }
}

fn sphere(id: &str, width: u32) -> RigCamera {
    RigCamera {
        cam_from_rig: DMat3::IDENTITY,
        projection: Projection::Equirectangular { size: UVec2::new(width, width / 2) },
        ..camera(id, 0.0, 4)
    }
}

fn north() -> View {
    View::look(EYE, 0.0, 0.0, PI / 3.0, UVec2::new(1024, 512))
}

/// Without mesh.
fn blind() -> Sight {
    Surfaces::default().sight(&north())
}

fn choose(panoramas: Vec<Arc<Panorama>>, limits: &FetchLimits) -> Vec<WantedImage> {
    choose_photographs(panoramas, &north(), &blind(), limits, &|_| false, &|_| 1.0)
        .expect("names are good")
}

/// Of two panoramas, of which one is wanted finely, that which is held stays while the eye wavers between them.
#[test]
fn nothing_flickers_between_two_panoramas() {
    let limits = FetchLimits { panoramas: 1, ..FetchLimits::default() };
    let at = |x: f64| {
        let rig = || vec![camera("c", 0.0, 512)];
        vec![
            panorama("left", DVec3::X * (-4.0 - x), rig()),
            panorama("right", DVec3::X * (4.0 - x), rig()),
        ]
    };
    let mut held = "left".to_owned();
    let mut changes = 0;
    let mut look = |x: f64, steadiness: f64| {
        let favour = |panorama: &Panorama| if panorama.id == held { steadiness } else { 1.0 };
        let wanted = choose_photographs(at(x), &north(), &blind(), &limits, &|_| false, &favour)
            .expect("named");
        changes += usize::from(wanted[0].panorama.id != held);
        held.clone_from(&wanted[0].panorama.id);
        changes
    };
    for x in [0.03, -0.03, 0.03, -0.03] {
        assert_eq!(look(x, 1.25), 0);
    }
    assert_eq!(look(0.6, 1.25), 1, "it is clearly nearer");
    assert_eq!((look(-0.03, 1.0), look(0.03, 1.0)), (2, 3), "without, it flickers");
}

fn ids(wanted: &[WantedImage]) -> Vec<String> {
    wanted.iter().flat_map(|w| w.photographs.iter().map(|(id, ..)| id.to_string())).collect()
}

#[test]
fn cameras_that_see_nothing_of_the_view_are_left_out() {
    let rig = || vec![camera("north", 0.0, 1024), camera("south", PI, 1024)];
    let behind = panorama("behind", DVec3::Y * -5.0, rig());
    let ahead = panorama("ahead", DVec3::Y * 20.0, rig());
    let wanted = choose(vec![ahead, behind], &FetchLimits::default());
    // From behind only the camera that looks the same way sees what the view sees; from ahead
    // both do.
    assert_eq!(ids(&wanted), ["behind/north", "ahead/north", "ahead/south"]);
}

#[test]
fn the_nearest_panoramas_count_whatever_their_order() {
    let all: Vec<_> = (1..=9)
        .map(|i| panorama(&format!("p{i}"), DVec3::Y * f64::from(i), vec![camera("c", 0.0, 512)]))
        .collect();
    let limits = FetchLimits { panoramas: 3, ..FetchLimits::default() };
    let wanted = choose(all.clone(), &limits);
    let forward = ids(&wanted);
    // The last stands for their district: it is the nearest to its centre.
    assert_eq!(forward, ["p1/c", "p2/c", "p3/c", "p9/c"]);
    let coarse: Vec<bool> = wanted.iter().map(|image| image.level == image.first_level).collect();
    assert_eq!(coarse, [false, false, false, true]);
    let shares: f64 = wanted.iter().map(|image| image.share).sum();
    assert!(shares <= 1.0 + 1e-9 && wanted.iter().all(|image| image.share > 0.0), "{shares}");
    assert_eq!(ids(&choose(all.into_iter().rev().collect(), &limits)), forward);
}

#[test]
fn the_level_is_the_coarsest_that_is_sharp_enough() {
    // The view has 443 pixels a radian in its middle. A camera of 90° and 1024 pixels has
    // 512, so its original is wanted; one of 4096 pixels has four times as many, so that
    // a level of a quarter is.
    let level = |side| {
        choose(
            vec![panorama("p", DVec3::Y * -0.5, vec![camera("c", 0.0, side)])],
            &FetchLimits::default(),
        )[0]
        .level
    };
    assert_eq!((level(512), level(1024), level(4096)), (0, 0, 2));
}

#[test]
fn what_is_too_large_for_the_receiver_is_taken_coarser() {
    let level = |camera, image_side| {
        let limits = FetchLimits { image_side, ..FetchLimits::default() };
        choose(vec![panorama("p", DVec3::Y * -0.5, vec![camera])], &limits)[0].level
    };
    let sides = [1024, 1023, 256, 1].map(|side| level(camera("c", 0.0, 1024), side));
    assert_eq!(sides[..3], [0, 1, 2]);
    assert_eq!(sides[3], level(camera("c", 0.0, 1024), 2), "the coarsest, where none is so small");
    // Of a sphere the faces count, a quarter as wide.
    assert_eq!([512, 511].map(|side| level(sphere("s", 2048), side)), [0, 1]);
}

#[test]
fn too_many_pixels_make_all_coarser() {
    let all: Vec<_> = (1..=4)
        .map(|i| panorama(&format!("p{i}"), DVec3::Y * f64::from(-i), vec![camera("c", 0.0, 512)]))
        .collect();
    let limits = FetchLimits { image_pixels: 4 * 256 * 256, ..FetchLimits::default() };
    let wanted = choose(all.clone(), &limits);
    assert!(wanted.iter().all(|image| image.level == 1) && wanted.len() == 4);
    // Not even the coarsest levels of all fit: the farthest go.
    let limits = FetchLimits { image_pixels: 2 * 16 * 16, ..limits };
    assert_eq!(ids(&choose(all, &limits)), ["p1/c", "p2/c"]);
}

#[test]
fn a_sphere_gives_the_faces_that_matter_and_can_be_left_out_in_part() {
    let at = panorama("s", DVec3::Y * -0.5, vec![sphere("sphere", 2048)]);
    let wanted = choose(vec![Arc::clone(&at)], &FetchLimits::default());
    assert!(ids(&wanted).contains(&"s/front".to_owned()));
    assert!(!ids(&wanted).contains(&"s/back".to_owned()), "{:?}", ids(&wanted));
    for (id, posed, face) in &wanted[0].photographs {
        let face = &flaneur_scene::CUBE_FACES[face.expect("a face")];
        assert_eq!((id.camera(), posed.lens), (face.name, CubeFace::lens(512)));
    }
    let without = |id: &ImageId| id.camera() == "front";
    let wanted = choose_photographs(
        vec![at],
        &north(),
        &blind(),
        &FetchLimits::default(),
        &without,
        &|_| 1.0,
    );
    assert!(!ids(&wanted.expect("names are good")).contains(&"s/front".to_owned()));
}

#[test]
fn the_first_level_is_small_and_never_finer_than_the_wanted_one() {
    let wanted = choose(
        vec![panorama("p", DVec3::Y * -0.5, vec![camera("c", 0.0, 1024), camera("d", 0.1, 64)])],
        &FetchLimits::default(),
    );
    let levels: Vec<_> = wanted.iter().map(|w| (w.level, w.first_level)).collect();
    assert_eq!(levels, [(0, 4), (0, 0)]);
    let steps: Vec<u32> = wanted[0].steps().collect();
    assert_eq!(steps, [4, 3, 2, 1, 0]);
}

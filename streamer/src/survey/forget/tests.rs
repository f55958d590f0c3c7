use std::f64::consts::FRAC_PI_2;
use std::io::Cursor;
use std::sync::Arc;

use flaneur_scene::{
    Bounds3, Intrinsics, Lens, Mask, Panorama, Projection, RigCamera, SceneInfo, StoredImage, View,
};
use glam::{DMat3, DVec3, UVec2};
use image::{GrayImage, ImageFormat};

use super::*;
use crate::choose::{WantedImage, district_of};
use crate::decode::decode_mask;

fn scene() -> SceneInfo {
    SceneInfo {
        name: "s".into(),
        crs: "local".into(),
        geographic_origin: None,
        origin: DVec3::ZERO,
        bounds: Bounds3 { min: DVec3::splat(-1e6), max: DVec3::splat(1e6) },
        footprints: 0,
        panoramas: 1,
        images: 1,
        ground: None,
        point_sources: Vec::new(),
        version: "1".into(),
    }
}

fn panorama(id: &str, x: f64) -> Arc<Panorama> {
    let size = UVec2::splat(64);
    let image = StoredImage { bytes: 1, crc32: 0 };
    let camera = RigCamera {
        id: "c".into(),
        position_in_rig: DVec3::ZERO,
        cam_from_rig: DMat3::IDENTITY,
        projection: Projection::Pinhole(Lens::pinhole(
            size,
            Intrinsics::from_fov_y(FRAC_PI_2, size),
        )),
        levels: vec![image],
        mask: Some(Mask { name: format!("mask of {id}"), image }),
        version: "1".into(),
    };
    Arc::new(Panorama {
        id: id.into(),
        position: DVec3::X * x,
        world_from_rig: DMat3::IDENTITY,
        time: None,
        uncertainty_m: 0.1,
        cameras: vec![camera],
    })
}

/// A street of a panorama a kilometre, each with a mask of 4096 pixels of its own.
fn survey() -> Survey {
    let mut survey = Survey::new(Arc::new(scene()));
    let mut png = Cursor::new(Vec::new());
    GrayImage::new(64, 64).write_to(&mut png, ImageFormat::Png).expect("an image");
    for index in 0..10 {
        let (id, x) = (format!("p{index}"), 1000.0 * f64::from(index));
        let district = district_of(glam::DVec2::new(x, 0.0)).expect("near");
        survey.panoramas.insert(district, vec![panorama(&id, x)]);
        let mask = decode_mask("a mask", png.get_ref()).expect("a mask");
        survey.masks.insert(format!("mask of {id}").into(), Arc::new(mask));
    }
    survey
}

fn at(x: f64) -> ViewRequest {
    ViewRequest::new(View::look(DVec3::X * x, 0.0, 0.0, 1.0, UVec2::new(64, 32)))
}

#[test]
fn panoramas_far_away_are_forgotten_where_there_are_too_many() {
    let mut survey = survey();
    // A district counts, too, so that empty ones are bounded.
    assert!(survey.forget_panoramas(&at(3000.0), 20).is_empty());
    let forgotten = survey.forget_panoramas(&at(3000.0), 19);
    assert_eq!(forgotten.len(), 9);
    assert_eq!(survey.panoramas.values().map(|d| &d[0].id).collect::<Vec<_>>(), ["p3"]);
    assert!(!forgotten.contains(&Part::Panoramas((60, 0))));
}

#[test]
fn masks_that_nothing_wanted_has_are_forgotten_where_they_take_too_much() {
    let mut survey = survey();
    let panorama = panorama("p7", 7000.0);
    let (id, _) = panorama.photographs().expect("named").remove(0);
    let image = WantedImage::finest(&panorama, &id).expect("named").expect("there");
    let part = Part::Image { panorama: "p7".into(), camera: 0, level: 0 };
    let targets = Targets::from([(part, Target::Image(image, 0))]);
    assert!(survey.forget_masks(&targets, 10 * 4096).is_empty());
    let forgotten = survey.forget_masks(&targets, 10 * 4096 - 1);
    assert_eq!(forgotten.len(), 9);
    assert_eq!(survey.masks.keys().map(|name| &**name).collect::<Vec<_>>(), ["mask of p7"]);
    assert!(forgotten.contains(&Part::Mask("mask of p6".into())));
}

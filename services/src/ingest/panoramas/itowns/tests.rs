//! Poses and calibrations as published, and their faults.

use serde_json::json;

use super::*;
use crate::ingest::panoramas::tests::survey::Survey;
use flaneur_scene::{Distortion, world_from_rig};
use glam::DMat3;

fn read_survey(survey: &Survey) -> Vec<Draft> {
    let job = Job::new(survey.folder.path(), 1 << 26);
    let exact = 0.483_f64.to_radians();
    read_with(&job, &survey.spec(), &|_| Ok(-exact)).expect("valid")
}

#[test]
fn poses_and_cameras_are_read_as_published() {
    let survey = Survey::new();
    let drafts = read_survey(&survey);
    assert_eq!(drafts.len(), 2);
    let first = &drafts[0];
    assert_eq!((first.id.as_str(), first.uncertainty_m), ("1", 0.3));
    assert_eq!(first.time.as_deref(), Some("2014-06-16T12:31:34Z"));
    assert_eq!(first.position, DVec3::new(651_003.0, 6_861_000.0, 42.0));
    let expected = world_from_rig(90f64.to_radians(), 1f64.to_radians(), -0.5_f64.to_radians());
    assert!((first.world_from_rig - expected).abs().to_cols_array().iter().all(|d| *d < 1e-15));
    let [seven, b] = first.cameras.as_slice() else { panic!("{first:?}") };
    assert_eq!((seven.id.as_str(), b.id.as_str()), ("7", "b"));
    assert!(seven.image.ends_with("images/7-001.jpg") && seven.mask.is_none());
    assert!(b.mask.as_ref().is_some_and(|m| m.image.ends_with("masks/b.jpg")));
    // Rows, not columns: the camera looks along the rig's forward axis.
    assert_eq!(seven.cam_from_rig * DVec3::Y, DVec3::Z);
    let DraftLens::Calibrated(lens) = seven.lens else { panic!("{seven:?}") };
    assert!(matches!(lens.distortion, Distortion::RadialPixels { limit_px: 900.0, .. }));
}

#[test]
fn calibrations_without_distortion_limit_or_masks() {
    let mut survey = Survey::new();
    survey.calibration[0]["distortion"].as_object_mut().expect("an object").remove("limit");
    survey.calibration[1]["distortion"] = json!(null);
    survey.calibration[1]["mask"] = json!(null);
    let drafts = read_survey(&survey);
    let lens = |i: usize| match drafts[0].cameras[i].lens {
        DraftLens::Calibrated(lens) => lens,
        DraftLens::Sphere => panic!("a sphere"),
    };
    // 1 − 1e-7 r² folds where 3e-7 r² = 1.
    assert!((lens(0).distortion.limit() - (1.0 / 3e-7_f64).sqrt()).abs() < 1e-6);
    assert_eq!(lens(1).distortion, Distortion::None);
    assert!(drafts[0].cameras[1].mask.is_none());
}

#[test]
fn rounded_rotations_are_mended() {
    let mut survey = Survey::new();
    survey.calibration[0]["rotation"] = json!([0.8660, 0.5000, 0, 0, 0, -1, -0.5000, 0.8660, 0]);
    let rotation = read_survey(&survey)[0].cameras[0].cam_from_rig;
    let error = rotation * rotation.transpose() - DMat3::IDENTITY;
    assert!(error.abs().to_cols_array().iter().all(|d| *d < 1e-15), "{error}");
}

#[test]
fn faults_of_the_calibration_name_camera_value_and_remedy() {
    type Change = fn(&mut serde_json::Value);
    let cases: [(Change, &str); 12] = [
        (
            |c| c[0]["rotation"][0] = json!(1.01),
            "camera 7: its rotation is not orthonormal: it deviates by 2.010e-2",
        ),
        (|c| c[0]["rotation"][5] = json!(1), "deviates by 2.000e0"),
        (|c| c[1]["rotation"] = json!([1, 0]), "camera \"b\": invalid length 2"),
        (
            |c| drop(c[1].as_object_mut().map(|o| o.remove("projection"))),
            "camera \"b\": missing field `projection`",
        ),
        (|c| c[0]["projection"][1] = json!(0.5), "a skew is not supported"),
        (|c| c[0]["projection"][0] = json!(-5), "its focal lengths are -5 and 500"),
        (|c| c[0]["size"] = json!([0, 4]), "its size is [0, 4]"),
        (|c| c[0]["distortion"]["limit"] = json!(-1), "its distortion limit is -1"),
        (|c| c[1]["id"] = json!(7), "camera 7: it is listed twice"),
        (|c| c[1]["mask"] = json!("../../secret.jpg"), "leaves the folder"),
        (|c| *c = json!([]), "it lists no camera"),
        (|c| *c = json!({"cameras": []}), "line 1, column 0: invalid type: map"),
    ];
    for (change, expected) in cases {
        let mut survey = Survey::new();
        change(&mut survey.calibration);
        let message = survey.refusal("calibration.json");
        assert!(message.contains(expected), "{message}, not {expected}");
    }
}

#[test]
fn a_camera_that_has_images_but_no_calibration_is_named() {
    let mut survey = Survey::new();
    survey.calibration.as_array_mut().expect("a list").truncate(1);
    let message = survey.refusal("calibration.json");
    assert!(
        message.contains("camera \"b\": it is missing, but there is an image of it, \"b-001.jpg\""),
        "{message}"
    );
}

#[test]
fn faults_of_the_poses_name_panorama_value_and_remedy() {
    type Change = fn(&mut serde_json::Value);
    let cases: [(Change, &str); 7] = [
        (|p| p[1]["pitch"] = json!(95), "panorama \"2\": the pitch is 95"),
        (|p| p[1]["easting"] = json!(1e12), "panorama \"2\": x is 1000000000000"),
        (|p| p[1]["id"] = json!(1), "panorama \"1\": a second panorama \"1\""),
        (|p| p[0]["id"] = json!("../x"), "cannot be part of an identifier"),
        (|p| p[0]["heading"] = json!("north"), "invalid type: string"),
        (|p| drop(p[0].as_object_mut().map(|o| o.remove("roll"))), "missing field `roll`"),
        (|p| *p = json!({}), "line 1, column 0"),
    ];
    for (change, expected) in cases {
        let mut survey = Survey::new();
        change(&mut survey.poses);
        let message = survey.refusal("poses.json");
        assert!(message.contains(expected), "{message}, not {expected}");
    }
}

//! Pyramids, masks, resumption and damage, on a small survey.

use std::collections::BTreeMap;
use std::fs;
use std::time::SystemTime;

use flaneur_scene::StoredImage;
use image::ImageFormat;

use super::*;
use crate::ingest::panoramas::tests::survey::{SIZE, Survey, decoded, encoded};

fn job(work: &tempfile::TempDir) -> Job {
    Job::new(work.path(), 1 << 26)
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

#[test]
fn level_0_is_the_original_and_the_rest_are_its_halves() {
    let (survey, work) = (Survey::new(), folder());
    let staged = survey.ingest(&job(&work)).expect("ingested").expect("panoramas");
    assert_eq!((staged.panoramas, staged.images), (2, 4));
    // 300, 150 and 75 pixels, four images; one mask.
    assert_eq!(staged.objects.len(), 4 * 3 + 1);
    assert!(staged.objects.iter().all(|(_, file)| file.starts_with(work.path())));
    let original = fs::read(survey.path("images/7-001.jpg")).expect("the original");
    let levels: Vec<_> =
        staged.objects.iter().filter(|(path, _)| path.starts_with("panoramas/1/7/")).collect();
    assert_eq!(fs::read(&levels[0].1).expect("level 0"), original);
    for (level, (path, file)) in levels.into_iter().enumerate() {
        assert!(path.ends_with(&format!("/{level}.jpg")), "{path}");
        let image = decoded(file);
        let side = |side: u32| (0..level).fold(side, |side, _| side.div_ceil(2));
        assert_eq!(image.dimensions(), (side(SIZE.x), side(SIZE.y)), "{path}");
        let bytes = fs::read(file).expect("staged");
        let stored = StoredImage { bytes: bytes.len() as u64, crc32: crc32fast::hash(&bytes) };
        assert_eq!(stored_image(file).expect("readable"), stored);
        // The ramp over the width is a ramp in every half; JPEG costs a few grey levels.
        let (width, height) = image.dimensions();
        for share in [0.25, 0.5, 0.75] {
            let pixel = image.get_pixel((f64::from(width) * share) as u32, height / 2);
            let expected = 255.0 * share;
            assert!((f64::from(pixel[0]) - expected).abs() < 12.0, "{path}: {pixel:?}");
        }
    }
}

#[test]
fn masks_keep_what_is_not_the_excluded_colour() {
    let (survey, work) = (Survey::new(), folder());
    let staged = survey.ingest(&job(&work)).expect("ingested").expect("panoramas");
    let masks: Vec<_> =
        staged.objects.iter().filter(|(path, _)| path.starts_with("masks/b.")).collect();
    let [(path, file)] = masks.as_slice() else { panic!("{masks:?}") };
    assert!(path.ends_with(".png"), "{path}");
    let mask = image::open(file).expect("decodes");
    assert_eq!(mask.color(), image::ColorType::L8);
    let mask = mask.into_luma8();
    assert_eq!(mask.dimensions(), (150, 100));
    // White, the left third, is the vehicle; ringing at the edge is thresholded away.
    for (x, y, pixel) in mask.enumerate_pixels() {
        assert_eq!(pixel[0], if x < 50 { 0 } else { 255 }, "{x}, {y}");
    }
}

/// When each file below the work folder was written.
fn written(work: &tempfile::TempDir, staged: &StagedPanoramas) -> BTreeMap<String, SystemTime> {
    let time = |file: &Path| fs::metadata(file).and_then(|m| m.modified()).expect("a file");
    assert!(staged.table.starts_with(work.path()));
    staged.objects.iter().map(|(path, file)| (path.clone(), time(file))).collect()
}

#[test]
fn finished_images_are_found_again() {
    let (survey, work) = (Survey::new(), folder());
    let first = survey.ingest(&job(&work)).expect("ingested").expect("panoramas");
    let before = written(&work, &first);
    // As if killed while the second image was being written: no record of it, half a level.
    // The mask is the first object, then three levels an image.
    let record = first.objects[4].1.with_file_name("finished.json");
    fs::remove_file(&record).expect("there is a record");
    fs::write(&first.objects[5].1, b"half a lev").expect("written");
    fs::write(first.objects[6].1.with_extension("jpg.part"), b"").expect("written");
    let second = survey.ingest(&job(&work)).expect("ingested").expect("panoramas");
    assert_eq!(second, first);
    let after = written(&work, &second);
    let rewritten: Vec<usize> = before
        .values()
        .zip(after.values())
        .enumerate()
        .filter_map(|(i, (before, after))| (before != after).then_some(i))
        .collect();
    assert_eq!(rewritten, [4, 5, 6]);
    assert!(record.is_file());
    decoded(&second.objects[5].1);
}

#[test]
fn another_original_has_another_version() {
    let (survey, work) = (Survey::new(), folder());
    let first = survey.ingest(&job(&work)).expect("ingested").expect("panoramas");
    survey.write("images/7-001.jpg", &encoded(SIZE, 9, ImageFormat::Jpeg));
    let second = survey.ingest(&job(&work)).expect("ingested").expect("panoramas");
    let paths = |staged: &StagedPanoramas| {
        staged.objects.iter().map(|(path, _)| path.clone()).collect::<Vec<_>>()
    };
    let changed = paths(&first).iter().zip(&paths(&second)).filter(|(a, b)| a != b).count();
    assert_eq!(changed, 3, "the three levels of one image");
}

#[test]
fn other_bytes_of_one_original_have_another_version() {
    let (survey, work) = (Survey::new(), folder());
    let first = survey.ingest(&job(&work)).expect("ingested").expect("panoramas");
    // As an encoder on another processor makes it, of the same size.
    let level = &first.objects[5].1;
    let mut bytes = fs::read(level).expect("a level");
    let last = bytes.len() - 3;
    bytes[last] ^= 1;
    fs::write(level, bytes).expect("written");
    let second = survey.ingest(&job(&work)).expect("ingested").expect("panoramas");
    let moved: Vec<&str> = (first.objects.iter())
        .zip(&second.objects)
        .filter_map(|(a, b)| (a.0 != b.0).then_some(a.0.as_str()))
        .collect();
    assert_eq!(moved.len(), 3, "the three levels of one image: {moved:?}");
    assert!(first.objects.iter().zip(&second.objects).all(|(a, b)| a.1 == b.1));
}

#[test]
fn absent_images_are_counted_and_all_absent_is_an_error() {
    let (survey, work) = (Survey::new(), folder());
    fs::remove_file(survey.path("images/7-001.jpg")).expect("removed");
    fs::remove_file(survey.path("images/7-002.jpg")).expect("removed");
    fs::remove_file(survey.path("images/b-002.jpg")).expect("removed");
    fs::remove_file(survey.path("masks/b.jpg")).expect("removed");
    let job = job(&work);
    let staged = survey.ingest(&job).expect("ingested").expect("panoramas");
    assert_eq!((staged.panoramas, staged.images), (1, 1));
    let warnings = job.warnings();
    assert_eq!(
        warnings.counts(),
        BTreeMap::from([("absent-image".into(), 3), ("absent-mask".into(), 1)])
    );
    assert!(warnings.messages("absent-image")[0].contains("panorama \"1\""));
    assert!(warnings.messages("absent-image")[0].contains("images/7-001.jpg"));
    fs::remove_file(survey.path("images/b-001.jpg")).expect("removed");
    let message = survey.refusal("poses.json");
    assert!(message.contains("all 4 images are absent, the first is"), "{message}");
}

#[test]
fn damaged_images_stop_the_ingest_or_are_skipped_and_counted() {
    let survey = Survey::new();
    let whole = fs::read(survey.path("images/b-001.jpg")).expect("the original");
    survey.write("images/b-001.jpg", &whole[..whole.len() / 2]);
    survey.write("images/7-002.jpg", b"<html>404</html>");
    survey.write("masks/b.jpg", b"");
    let work = folder();
    let error = survey.ingest(&job(&work)).expect_err("damaged").to_string();
    assert!(error.contains("masks/b.jpg: it is empty; restore it"), "{error}");
    let mut skipping = job(&work);
    skipping.skip_damaged = true;
    let staged = survey.ingest(&skipping).expect("ingested").expect("panoramas");
    assert_eq!((staged.panoramas, staged.images), (2, 2));
    let warnings = skipping.warnings();
    assert_eq!(
        warnings.counts(),
        BTreeMap::from([("damaged-image".into(), 2), ("damaged-mask".into(), 1)])
    );
    assert!(
        warnings.messages("damaged-image")[0].contains("b-001.jpg: it is damaged or cut short")
    );
    assert!(warnings.messages("damaged-image")[1].contains("7-002.jpg: it is no JPEG"));
}

#[test]
fn sizes_must_fit_the_calibration_and_the_mask() {
    let survey = Survey::new();
    survey.write("images/7-001.jpg", &encoded(UVec2::new(300, 150), 1, ImageFormat::Jpeg));
    let message = survey.refusal("7-001.jpg");
    assert!(
        message
            .contains("300×150 pixels, not of the proportions of camera 7, calibrated for 600×400"),
        "{message}"
    );
    let survey = Survey::new();
    survey.write("masks/b.jpg", &encoded(UVec2::new(100, 100), 1, ImageFormat::Jpeg));
    // Whichever of the two images comes first.
    assert!(survey.refusal("/b-00").contains("its mask is 100×100"));
}

/// Within a pixel: 301 × 201 is 600 × 400 scaled and rounded.
#[test]
fn proportions_are_compared_within_a_pixel() {
    let same = |a: [u32; 2], b: [u32; 2]| same_proportions(a.into(), b.into());
    assert!(same([600, 400], [301, 201]) && same([301, 201], [600, 400]));
    assert!(same([2048, 2048], [1024, 1024]) && same([1242, 375], [621, 188]));
    assert!(!same([600, 400], [300, 202]) && !same([1024, 1024], [2048, 2046 - 3]));
}

#[test]
fn other_formats_are_stored_as_jpeg_and_counted() {
    let (survey, work) = (Survey::new(), folder());
    survey.write("images/7-001.jpg", &encoded(SIZE, 1, ImageFormat::Png));
    let job = job(&work);
    let staged = survey.ingest(&job).expect("ingested").expect("panoramas");
    assert_eq!(job.warnings().counts(), BTreeMap::from([("recompressed-image".into(), 1)]));
    let level_0 = staged.objects.iter().find(|(path, _)| path.starts_with("panoramas/1/7/"));
    let level_0 = fs::read(&level_0.expect("level 0").1).expect("a file");
    assert_eq!(image::guess_format(&level_0).ok(), Some(ImageFormat::Jpeg));
}

#[test]
fn images_beyond_the_memory_are_refused_with_what_they_need() {
    let (survey, work) = (Survey::new(), folder());
    let error = survey.ingest(&Job::new(work.path(), 100_000)).expect_err("small").to_string();
    assert!(
        error.contains("MiB to decode and halve") && error.contains("--memory 1MiB"),
        "{error}"
    );
    // Enough for one image at a time is enough.
    let work = folder();
    let bytes = fs::metadata(survey.path("images/7-001.jpg")).expect("a file").len();
    let one = bytes + u64::from(SIZE.x * SIZE.y) * 9;
    assert!(survey.ingest(&Job::new(work.path(), one)).expect("ingested").is_some());
}

#[test]
fn cancelling_stops_before_the_table() {
    let (survey, work) = (Survey::new(), folder());
    let job = job(&work);
    job.cancel();
    assert!(matches!(survey.ingest(&job), Err(IngestError::Cancelled)));
    assert!(!work.path().join("panoramas.fgb").exists());
}

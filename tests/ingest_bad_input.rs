//! Faulty surveys, stores and disks, given to the built program: each gets one line that names
//! file, place and remedy, exit code 2, and leaves the store as it was.

mod survey;

use std::path::Path;
use std::process::Command;

use las::Vector;
use survey::{Outcome, Survey, contents};

const SCENE: &str = "[scene]\nname = \"s\"\ncrs = \"EPSG:2154\"\n";
const POINTS: &str = "[[points]]\npath = \"points.la[sz]\"\n";
const ITOWNS: &str = "[[panoramas]]\nformat = \"itowns\"\nposes = \"poses.json\"\n\
                      calibration = \"rig.json\"\nimages = \"{camera}_{panorama}.jpg\"\n";
const COLMAP: &str = "[[panoramas]]\nformat = \"colmap\"\nmodel = \"model\"\nimages = \"images\"\n";

/// A survey of a few points that is published, so that there is something to lose.
fn published() -> Survey {
    let survey = Survey::empty();
    survey.write("points.laz", las_file(1_000, true));
    survey.write("street.toml", format!("{SCENE}{POINTS}"));
    survey.ingested(&[]);
    survey
}

/// Ingests what the survey has become: it must be refused for reasons that hold each of
/// `parts`, and the store must be as it was.
fn refused(survey: &Survey, arguments: &[&str], parts: &[&str]) {
    let before = survey.stored();
    let outcome = survey.ingest(arguments);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    let complaint = outcome.complaint();
    for part in parts {
        assert!(complaint.contains(part), "{part:?} is not in\n{complaint}");
    }
    assert!(complaint.contains("; "), "there is no remedy in\n{complaint}");
    assert!(survey.stored() == before, "the store has changed");
}

/// A LAS or LAZ file of points within a kilometre, the same at every call.
fn las_file(points: u32, laz: bool) -> Vec<u8> {
    let mut builder = las::Builder::from((1, 4));
    builder.point_format = las::point::Format::new(6).expect("a format");
    builder.point_format.is_compressed = laz;
    let transform = |offset| las::Transform { scale: 0.001, offset };
    builder.transforms =
        Vector { x: transform(651_000.0), y: transform(6_861_000.0), z: transform(0.0) };
    let file = tempfile::NamedTempFile::with_suffix(if laz { ".laz" } else { ".las" });
    let file = file.expect("temporary file");
    let header = builder.into_header().expect("a header");
    let mut writer = las::Writer::from_path(file.path(), header).expect("a writer");
    let mut state = 1_u64;
    let mut random = |range: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (state >> 40) as f64 / f64::from(1 << 24) * range
    };
    for _ in 0..points {
        let point = las::Point {
            x: 651_000.0 + random(1e3),
            y: 6_861_000.0 + random(1e3),
            z: random(50.0),
            intensity: random(65_000.0) as u16,
            gps_time: Some(random(1e6)),
            ..Default::default()
        };
        writer.write_point(point).expect("written");
    }
    writer.close().expect("closed");
    std::fs::read(file.path()).expect("readable")
}

fn patched(mut bytes: Vec<u8>, at: usize, new: &[u8]) -> Vec<u8> {
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

fn jpeg() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([x as u8 * 4, y as u8 * 4, 99]))
        .write_to(&mut bytes, image::ImageFormat::Jpeg)
        .expect("encoded");
    bytes.into_inner()
}

/// The same picture, claiming to have 60 000 x 60 000 pixels.
fn huge_jpeg() -> Vec<u8> {
    let bytes = jpeg();
    let frame = bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).expect("a frame header");
    let side = 60_000_u16.to_be_bytes();
    patched(patched(bytes, frame + 5, &side), frame + 7, &side)
}

const ROTATION: &str = "[1,0,0, 0,0,-1, 0,1,0]";

fn rig(id: &str, rotation: &str) -> String {
    format!(
        "[{{\"id\":{id},\"rotation\":{rotation},\"position\":[0,0,0],\
         \"projection\":[50,0,32,0,50,32,0,0,1],\"size\":[64,64]}}]"
    )
}

/// Adds a panorama, 7, of one camera, 1, to a published survey.
fn add_itowns(survey: &Survey) {
    survey.write("street.toml", format!("{SCENE}{POINTS}{ITOWNS}"));
    survey.write(
        "poses.json",
        "[{\"id\":7,\"easting\":651100,\"northing\":6861100,\"altitude\":3,\
         \"heading\":0,\"pitch\":0,\"roll\":0}]",
    );
    survey.write("rig.json", rig("1", ROTATION));
    survey.write("1_7.jpg", jpeg());
}

#[test]
fn the_surveys_are_good_until_they_are_broken() {
    let survey = published();
    add_itowns(&survey);
    let summary = survey.ingested(&["--confine"]);
    assert_eq!((&summary["images"], &summary["points"]), (&1.into(), &1_000.into()), "{summary}");
    assert_eq!(summary["warnings"], serde_json::json!({}));
}

#[test]
fn a_laz_cut_short() {
    let survey = published();
    let laz = las_file(20_000, true);
    survey.write("points.laz", &laz[..laz.len() / 2]);
    refused(&survey, &[], &["points.laz", "copy"]);
    let skipped = survey.ingest(&["--skip-damaged"]);
    assert_eq!(skipped.code, Some(2), "nothing is left: {}", skipped.stderr);

    survey.write("street.toml", format!("{SCENE}[[points]]\npath = \"*.laz\"\nname = \"p\"\n"));
    survey.write("good.laz", las_file(500, true));
    let summary = survey.ingested(&["--skip-damaged"]);
    assert_eq!(
        (&summary["points"], &summary["warnings"]["damaged-file"]),
        (&500.into(), &1.into())
    );
}

#[test]
fn a_las_that_claims_2_to_the_60_points() {
    let survey = published();
    std::fs::remove_file(survey.street().join("points.laz")).expect("removed");
    survey.write("points.las", patched(las_file(100, false), 247, &(1_u64 << 60).to_le_bytes()));
    refused(&survey, &[], &["points.las", "1152921504606846976"]);
}

#[test]
fn coordinates_that_are_no_numbers_or_out_of_range() {
    let survey = published();
    let laz = las_file(100, true);
    for (at, value, word) in [
        (155, f64::NAN, "NaN"),
        (155, 1e300, "offset"),
        (131, f64::NAN, "scale"),
        (139, 1e9, "scale"),
    ] {
        survey.write("points.laz", patched(laz.clone(), at, &value.to_le_bytes()));
        refused(&survey, &[], &["points.laz", "header", word]);
    }
    survey.write("points.laz", laz);

    add_itowns(&survey);
    let poses = std::fs::read_to_string(survey.street().join("poses.json")).expect("poses");
    survey.write("poses.json", poses.replace("651100", "1e300"));
    refused(&survey, &[], &["poses.json", "7", "x is 1e300"]);
    survey.write("poses.json", poses.replace("651100", "NaN"));
    refused(&survey, &[], &["poses.json, line 1"]);

    survey.write(
        "street.toml",
        format!("{SCENE}{POINTS}[ground]\nformat = \"points-json\"\npath = \"dtm.json\"\n"),
    );
    survey.write("dtm.json", "[{\"e\":651000,\"n\":6861000,\"h\":1},{\"e\":1,\"n\":1e40,\"h\":2}]");
    refused(&survey, &[], &["dtm.json"]);
}

#[test]
fn pictures_that_are_none_or_too_large() {
    let survey = published();
    add_itowns(&survey);
    survey.write("1_7.jpg", "this is no picture");
    refused(&survey, &[], &["1_7.jpg"]);
    survey.write("1_7.jpg", huge_jpeg());
    refused(&survey, &[], &["1_7.jpg", "60000"]);
    let cut = jpeg();
    survey.write("1_7.jpg", &cut[..cut.len() / 2]);
    refused(&survey, &[], &["1_7.jpg"]);
    std::fs::remove_file(survey.street().join("1_7.jpg")).expect("removed");
    refused(&survey, &[], &["poses.json", "absent", "1_7.jpg"]);
}

#[test]
fn bad_polygons_are_skipped_and_counted() {
    let survey = published();
    let ring = |points: &[(f64, f64)]| {
        let points: Vec<[f64; 2]> =
            points.iter().map(|(x, y)| [651_100.0 + x, 6_861_100.0 + y]).collect();
        serde_json::json!({"type": "Feature", "properties": {"h": 5},
            "geometry": {"type": "Polygon", "coordinates": [points]}})
    };
    let features = [
        ring(&[(0., 0.), (10., 0.), (10., 10.), (0., 10.), (0., 0.)]),
        ring(&[(0., 0.), (10., 10.), (10., 0.), (0., 10.), (0., 0.)]),
        ring(&[(0., 0.), (10., 0.)]),
        ring(&[(0., 0.), (5., 0.), (10., 0.), (0., 0.)]),
    ];
    let collection = serde_json::json!({"type": "FeatureCollection", "features": features});
    survey.write("b.geojson", collection.to_string());
    survey.write(
        "street.toml",
        format!(
            "{SCENE}{POINTS}[ground]\nformat = \"constant\"\nheight_m = 1\n\
             [[footprints]]\npath = \"b.geojson\"\nheight_property = \"h\"\n"
        ),
    );
    let summary = survey.ingested(&[]);
    assert_eq!(summary["footprints"], 1, "{summary}");
    let counts = summary["warnings"].as_object().expect("counts");
    let skipped: u64 = counts.values().filter_map(serde_json::Value::as_u64).sum();
    assert_eq!(skipped, 3, "{summary}");
}

#[test]
fn cameras_without_calibration() {
    let survey = published();
    add_itowns(&survey);
    survey.write("2_7.jpg", jpeg());
    refused(&survey, &[], &["rig.json", "camera", "2"]);

    survey.write("street.toml", format!("{SCENE}{POINTS}{COLMAP}"));
    survey.write("images/a.jpg", jpeg());
    survey.write("model/cameras.txt", "1 PINHOLE 64 64 50 50 32 32\n");
    survey.write("model/images.txt", "1 1 0 0 0 0 0 0 9 a.jpg\n\n");
    refused(&survey, &[], &["images.txt", "line 1", "camera 9"]);
}

#[test]
fn a_rotation_that_is_none() {
    let survey = published();
    add_itowns(&survey);
    survey.write("rig.json", rig("1", "[1,0,0, 0,0,-1, 0,2,0]"));
    refused(&survey, &[], &["rig.json", "camera", "1", "rotation"]);
}

#[test]
fn a_binary_model_cut_short() {
    let survey = published();
    survey.write("street.toml", format!("{SCENE}{POINTS}{COLMAP}"));
    survey.write("images/a.jpg", jpeg());
    survey.write("model/cameras.txt", "1 PINHOLE 64 64 50 50 32 32\n");
    // One image: number, quaternion, position, camera, name, no tie points.
    let mut model = 1_u64.to_le_bytes().to_vec();
    model.extend(1_u32.to_le_bytes());
    for value in [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0_f64] {
        model.extend(value.to_le_bytes());
    }
    model.extend(1_u32.to_le_bytes());
    model.extend(b"a.jpg\0");
    model.extend(0_u64.to_le_bytes());
    survey.write("model/images.bin", &model[..model.len() / 2]);
    std::fs::write(survey.street().join("model/cameras.bin"), camera_bin()).expect("file");
    std::fs::remove_file(survey.street().join("model/cameras.txt")).expect("removed");
    refused(&survey, &[], &["images.bin", "byte"]);
    survey.write("model/images.bin", patched(model.clone(), 0, &(1_u64 << 60).to_le_bytes()));
    refused(&survey, &[], &["images.bin"]);
    survey.write("model/images.bin", model);
    assert_eq!(survey.ingested(&[])["images"], 1, "whole, it is good");
}

/// One PINHOLE camera, number 1, of 64 x 64 pixels.
fn camera_bin() -> Vec<u8> {
    let mut bytes = 1_u64.to_le_bytes().to_vec();
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(1_i32.to_le_bytes());
    bytes.extend(64_u64.to_le_bytes());
    bytes.extend(64_u64.to_le_bytes());
    for value in [50.0, 50.0, 32.0, 32.0_f64] {
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

#[test]
fn paths_that_leave_the_folder_when_confined() {
    let survey = published();
    std::fs::copy(survey.street().join("points.laz"), survey.path().join("p.laz")).expect("copied");
    survey.write("street.toml", format!("{SCENE}[[points]]\npath = \"../p.laz\"\n"));
    refused(&survey, &["--confine"], &["street.toml, line 5", "\"../p.laz\"", "--confine"]);

    add_itowns(&survey);
    survey.write("../outside.jpg", jpeg());
    let rig = rig("1", ROTATION).replace("\"size\"", "\"mask\":\"../outside.jpg\",\"size\"");
    survey.write("rig.json", rig);
    let toml = format!("{SCENE}{POINTS}{ITOWNS}masks_exclude = \"white\"\n");
    survey.write("street.toml", toml);
    refused(&survey, &["--confine"], &["rig.json", "../outside.jpg", "--confine"]);
}

#[test]
fn keys_and_options_that_do_not_exist() {
    let survey = published();
    survey.write("street.toml", format!("{SCENE}[[points]]\npaht = \"points.laz\"\n"));
    refused(&survey, &[], &["street.toml, line 5", "`paht`", "`path`"]);
    let outcome = survey.ingest(&["--memory", "1MiB"]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("least is 64MiB"), "{}", outcome.stderr);
    survey.write("street.toml", format!("{SCENE}{POINTS}").replace("EPSG:2154", "EPSG:4326"));
    refused(&survey, &[], &["street.toml", "crs", "EPSG:4326", "projected"]);
}

#[test]
fn a_store_that_is_a_file() {
    let survey = published();
    let place = survey.path().join("a-file");
    std::fs::write(&place, "x").expect("file");
    for out in [place.clone(), place.join("below")] {
        let outcome = survey.ingest(&["--name", "t"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let mut command = Command::new(env!("CARGO_BIN_EXE_flaneur"));
        command.arg("ingest").arg(survey.street()).arg("--out").arg(&out);
        let output = command.arg("--work").arg(survey.path().join("work")).output();
        let outcome = Outcome::of(output.expect("starts"));
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.complaint().contains("a-file"), "{}", outcome.stderr);
    }
    assert_eq!(std::fs::read(&place).expect("still a file"), b"x");
}

#[test]
fn a_work_folder_in_the_store() {
    let survey = published();
    let inside = survey.store().join("work").display().to_string();
    let before = survey.stored();
    let mut command = Command::new(env!("CARGO_BIN_EXE_flaneur"));
    command.arg("ingest").arg(survey.street()).arg("--out").arg(survey.store());
    let outcome = Outcome::of(command.args(["--work", &inside]).output().expect("starts"));
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.complaint().contains("the work folder lies in the store"));
    assert!(survey.stored() == before);
}

/// Runs the ingest where `mount` (a line of shell that knows `$STORE` and `$WORK`) has been
/// done, and copies the store out again; `None`, with a word, where that is not permitted.
fn ingest_with(survey: &Survey, mount: &str) -> Option<Outcome> {
    let permitted = Command::new("unshare")
        .args(["-rm", "mount", "-t", "tmpfs", "x", "/mnt"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !permitted {
        eprintln!("skipped: mounting is not permitted here");
        return None;
    }
    let script = format!(
        "{mount} || exit 99\n\"$@\"; code=$?\ncp -r \"$STORE\" \"$AFTER\" || exit 99\nexit $code"
    );
    let command = survey.command(&[]);
    let output = Command::new("unshare")
        .args(["-rm", "sh", "-c", &script, "sh"])
        .arg(command.get_program())
        .args(command.get_args())
        .env("STORE", survey.store())
        .env("COPY", survey.path().join("copy"))
        .env("WORK", survey.path().join("work"))
        .env("AFTER", survey.path().join("after"))
        .output();
    let outcome = Outcome::of(output.expect("starts"));
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    let after = contents(&survey.path().join("after"));
    assert!(after == survey.stored(), "the store has changed");
    Some(outcome)
}

/// A published survey that has since become larger than 2 MiB.
fn grown() -> Survey {
    let survey = published();
    survey.write("points.laz", las_file(200_000, true));
    std::fs::create_dir_all(survey.path().join("work")).expect("folder");
    copy_folder(&survey.store(), &survey.path().join("copy"));
    survey
}

fn copy_folder(from: &Path, to: &Path) {
    assert!(Command::new("cp").arg("-r").args([from, to]).status().expect("cp").success());
}

#[test]
fn a_store_that_cannot_be_written() {
    let survey = grown();
    let mount = "mount --bind \"$STORE\" \"$STORE\" && mount -o remount,bind,ro \"$STORE\"";
    let Some(outcome) = ingest_with(&survey, mount) else { return };
    let complaint = outcome.complaint();
    assert!(complaint.contains("/store/s"), "{complaint}");
    assert!(complaint.contains("Read-only"), "{complaint}");
    assert!(complaint.contains("writable"), "{complaint}");
    assert!(!outcome.stderr.contains("read points"), "seen before any work: {}", outcome.stderr);
}

#[test]
fn a_store_on_a_full_disk() {
    let survey = grown();
    let mount = "mount -t tmpfs -o size=2m tmpfs \"$STORE\" && cp -r \"$COPY\"/. \"$STORE\"";
    let Some(outcome) = ingest_with(&survey, mount) else { return };
    let complaint = outcome.complaint();
    assert!(complaint.contains("/store/s/points/"), "{complaint}");
    assert!(complaint.contains("No space left"), "{complaint}");
    assert!(complaint.contains("free some space"), "{complaint}");
}

#[test]
fn a_work_folder_on_a_full_disk() {
    let survey = grown();
    let Some(outcome) = ingest_with(&survey, "mount -t tmpfs -o size=1m tmpfs \"$WORK\"") else {
        return;
    };
    let complaint = outcome.complaint();
    assert!(complaint.contains("/work/"), "{complaint}");
    assert!(complaint.contains("No space left"), "{complaint}");
    assert!(complaint.contains("--work"), "{complaint}");
}

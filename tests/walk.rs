//! `flaneur walk` as a person runs it.

mod command;
mod street;

use std::path::{Path, PathBuf};
use std::process::Stdio;

use command::{fail, flaneur, json, run, succeed, text};
use serde_json::{Value, json};
use street::SampleStreet;

/// The scene and where files go: making a scene takes longer than walking through it, so one serves
/// all.
struct Place {
    street: SampleStreet,
    files: PathBuf,
}

impl Place {
    fn file(&self, name: &str) -> PathBuf {
        self.files.join(name)
    }

    fn write(&self, name: &str, views: &Value) -> PathBuf {
        let path = self.file(name);
        std::fs::write(&path, views.to_string()).expect("writable");
        path
    }

    /// The first views of the street's own walk.
    fn views(&self, count: usize) -> Vec<Value> {
        let walk = json(&self.street.survey.join("truth/walk.json"));
        walk.as_array().expect("a list").iter().take(count).cloned().collect()
    }
}

#[test]
fn a_street_is_walked() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let street = runtime.block_on(SampleStreet::ingested("walk"));
    let files = street.store.with_file_name("files");
    std::fs::create_dir(&files).expect("the build folder is writable");
    let place = Place { street, files };
    what_is_asked_wrongly_is_said_in_one_line(&place);
    someone_who_stands_sees_everything_in_the_end(&place);
    someone_who_walks_is_measured_at_every_step(&place);
    #[cfg(unix)]
    an_interrupted_walk_is_written(&place);
}

fn samples(report: &Value) -> Vec<[f64; 4]> {
    let sample = |sample: &Value| {
        ["ms", "bytes", "ssim", "psnr_db"]
            .map(|key| sample[key].as_f64().unwrap_or_else(|| panic!("{key} of {sample}")))
    };
    report["samples"].as_array().expect("a list").iter().map(sample).collect()
}

/// What holds for every report.
fn assert_sound(report: &Value) {
    let samples = samples(report);
    for pair in samples.windows(2) {
        assert!(pair[0][0] < pair[1][0] && pair[0][1] <= pair[1][1], "{pair:?}");
    }
    for [_, _, ssim, psnr_db] in &samples {
        assert!((-1.0..=1.0).contains(ssim) && (0.0..=120.0).contains(psnr_db), "{report}");
    }
    let number = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("{key} of {report}"));
    let [first_ms, first_bytes, ..] = samples[0];
    assert_eq!(number("first_picture_ms"), first_ms);
    let taken = number("first_picture_bytes");
    assert!(taken > 0.0 && taken <= first_bytes, "{taken} {first_bytes}");
    assert!(samples[samples.len() - 1][1] <= number("bytes"));
    for (key, ssim) in [("ms_to_ssim_090", 0.90), ("ms_to_ssim_095", 0.95)] {
        let first = samples.iter().find(|sample| sample[2] >= ssim).map(|sample| sample[0]);
        assert_eq!(report[key].as_f64(), first, "{key}");
    }
    assert!(number("requests") > 2.0 && number("longest_frame_ms") > 0.0);
    assert!(number("bytes_wasted") <= number("bytes"), "{report}");
    assert!((0.0..=1.0).contains(&number("cache_hit_rate")) && report["cancelled"].is_u64());
    assert_eq!(report["profile"]["tcp_bytes_down"], report["bytes"]);
    assert!(report["machine"]["adapter"].is_string());
}

fn someone_who_stands_sees_everything_in_the_end(place: &Place) {
    let path = place.write("stand.json", &json!(place.views(1)));
    let (file, page) = (place.file("stand.report.json"), place.file("stand.html"));
    let link = ["--bandwidth", "2M", "--latency", "5ms", "--size", "128x96"];
    let files = ["--report", text(&file), "--html", text(&page)];
    let store = text(&place.street.store);
    let summary = succeed(&[&["walk", store, "--path", text(&path)], &link[..], &files].concat());
    assert!(summary.contains("first picture") && summary.contains("SSIM 0.95"), "{summary}");

    let report = json(&file);
    assert_sound(&report);
    assert_eq!(report["settings"]["bandwidth_bits_per_s"], 2e6);
    assert_eq!(report["settings"]["walk_s"], 0.0);
    let samples = samples(&report);
    let [.., ssim, psnr_db] = samples[samples.len() - 1];
    // Brightness goes to where it belongs over many frames, ever more slowly.
    assert!(ssim > 0.995 && psnr_db > 40.0, "the last picture is the whole one: {samples:?}");
    assert!(samples[0][2] < ssim && samples[0][1] < samples[samples.len() - 1][1], "{samples:?}");
    let page = std::fs::read_to_string(page).expect("written");
    assert!(page.contains("SSIM against megabytes received") && !page.contains("http"));
}

fn someone_who_walks_is_measured_at_every_step(place: &Place) {
    let mut views = place.views(2);
    for (view, time_s) in views.iter_mut().zip([0.0, 2.5]) {
        view["time_s"] = time_s.into();
    }
    let (path, file) = (place.write("walk.json", &json!(views)), place.file("walk.report.json"));
    let store = place.street.store.join("sample");
    let arguments = ["walk", text(&store), "--path", text(&path), "--size", "96x64"];
    succeed(&[&arguments[..], &["--report", text(&file)]].concat());
    let report = json(&file);
    assert_sound(&report);
    assert_eq!(report["settings"]["walk_s"], 2.5);
    assert!(report["settings"]["bandwidth_bits_per_s"].is_null());
    let samples = samples(&report);
    assert!(samples.len() > 2 && samples[samples.len() - 1][0] >= 2500.0, "{samples:?}");
    assert!(samples[samples.len() - 1][2] > 0.995, "{samples:?}");
}

#[cfg(unix)]
fn an_interrupted_walk_is_written(place: &Place) {
    let mut views = place.views(2);
    for (view, time_s) in views.iter_mut().zip([0.0, 600.0]) {
        view["time_s"] = time_s.into();
    }
    let (path, file) = (place.write("long.json", &json!(views)), place.file("long.report.json"));
    let mut process = flaneur()
        .args(["walk", text(&place.street.store), "--path", text(&path), "--size", "64x48"])
        .args(["--report", text(&file), "-v"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary");
    // The first picture is said, so that there is something to write.
    let stderr = process.stderr.take().expect("piped");
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(stderr));
    let seen = lines.by_ref().any(|line| line.expect("text").contains("first picture"));
    assert!(seen, "the walk ended before a picture was there");
    let told =
        std::process::Command::new("kill").args(["-INT", &process.id().to_string()]).status();
    assert!(told.expect("kill starts").success());
    let said: Vec<String> = lines.map(|line| line.expect("text")).collect();
    assert_eq!(process.wait().expect("it ends").code(), Some(130), "{said:?}");
    assert!(said.iter().any(|line| line == "flaneur: interrupted"), "{said:?}");
    let report = json(&file);
    assert_sound(&report);
    assert!(samples(&report).iter().all(|sample| sample[0] < 600e3));
}

fn what_is_asked_wrongly_is_said_in_one_line(place: &Place) {
    let store = text(&place.street.store);
    let (good, report) =
        (place.write("good.json", &json!(place.views(1))), place.file("never.json"));
    let with = |source: &str, path: &Path, code: i32| {
        fail(code, &["walk", source, "--path", text(path), "--report", text(&report)])
    };
    let mut views = place.views(2);
    views[1]["time_s"] = 3.0.into();
    let untimed = place.write("untimed.json", &json!(views));
    let error = with(store, &untimed, 2);
    assert!(error.contains("untimed.json: view 1") && error.contains("time_s"), "{error}");
    (views[0]["time_s"], views[1]["time_s"]) = (4.0.into(), 3.0.into());
    let error = with(store, &place.write("back.json", &json!(views)), 2);
    assert!(error.contains("view 2: \"time_s\" is 3") && error.contains("at least 4"), "{error}");
    assert!(with(store, &place.file("absent.json"), 2).contains("absent.json"));
    assert!(with(text(&place.file("no-store")), &good, 2).contains("ingest"));
    with("https://localhost/scene", &good, 2);
    // Nobody listens on port 1; that is no fault of what was typed.
    assert!(with("http://127.0.0.1:1/sample", &good, 1).contains("running"));
    let nowhere = place.file("no/report.json");
    let error = fail(2, &["walk", store, "--path", text(&good), "--report", text(&nowhere)]);
    assert!(error.contains("folder does not exist"), "{error}");
    // What clap refuses.
    for wrong in [
        &["--bandwidth", "10"][..],
        &["--bandwidth", "fast"],
        &["--latency", "50"],
        &["--speed", "0"],
        &["--size", "64x5"],
    ] {
        let arguments = ["walk", store, "--path", text(&good), "--report", text(&report)];
        let output = run(&[&arguments[..], wrong].concat());
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
    }
    assert!(!report.exists());
}

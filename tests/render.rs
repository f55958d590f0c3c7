//! `flaneur render`, `info` and `serve` as a person runs them.

mod command;
mod street;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};

use command::{fail, flaneur, json, run, succeed, text};
use image::RgbImage;
use serde_json::Value;
use street::SampleStreet;

/// `flaneur serve` on a free port; it ends with the value.
struct Server {
    process: Child,
    url: String,
}

impl Server {
    fn start(store: &Path) -> Self {
        let mut process = flaneur()
            .arg("serve")
            .arg(store)
            .args(["--no-render", "--listen", "127.0.0.1:0"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the binary");
        let mut line = String::new();
        let stdout = process.stdout.take().expect("piped");
        BufReader::new(stdout).read_line(&mut line).expect("a line");
        let url = line.trim().strip_prefix("serving ").expect("serving URL").to_owned();
        Self { process, url }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

fn picture(path: &Path) -> RgbImage {
    image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).into_rgb8()
}

/// The scene, and where pictures go. Making a scene takes longer than looking at it, so one
/// serves all.
struct Place {
    street: SampleStreet,
    pictures: PathBuf,
}

impl Place {
    fn file(&self, name: &str) -> PathBuf {
        self.pictures.join(name)
    }
}

#[test]
fn a_scene_is_rendered() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let street = runtime.block_on(SampleStreet::ingested("render"));
    let pictures = street.store.with_file_name("pictures");
    std::fs::create_dir(&pictures).expect("the build folder is writable");
    let place = Place { street, pictures };
    a_server_gives_the_pixels_of_the_store(&place);
    a_photograph_is_rendered_like_itself(&place);
    what_is_asked_wrongly_is_said_in_one_line(&place);
    info_tells_what_there_is(&place);
    a_budget_that_cannot_be_held_takes_the_cheapest_settings(&place);
    a_view_far_outside_is_said(&place);
}

fn a_view_far_outside_is_said(place: &Place) {
    let (store, out) = (text(&place.street.store).to_owned(), place.file("far.png"));
    let said = |view: &str| {
        let arguments = ["render", &store, "--view", view, "--size", "32x24", "-o", text(&out)];
        let output = run(&arguments);
        assert!(output.status.success(), "it is no error");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let far = said("0,0,50,0,0");
    assert!(far.contains("outside of the scene") && far.contains("200 m"), "{far}");
    let truth = json(&place.street.survey.join("truth/views.json"));
    let at = |axis: usize| truth[0]["position"][axis].as_f64().expect("a number");
    let near = said(&format!("{},{},{},0,0", at(0), at(1), at(2)));
    assert!(!near.contains("outside"), "{near}");
}

fn a_budget_that_cannot_be_held_takes_the_cheapest_settings(place: &Place) {
    let frame = |budget: &str| {
        let (out, report) = (place.file("budget.png"), place.file("budget.json"));
        let arguments = ["render", text(&place.street.store), "--like", "101/602", "--size"];
        let files = ["96x64", "-o", text(&out), "--report", text(&report)];
        let output = run(&[&arguments[..], &files, &["--budget-ms", budget]].concat());
        assert!(output.status.success());
        let warned = String::from_utf8_lossy(&output.stderr).contains("with the cheapest settings");
        let frame = json(&report)["frames"][0].clone();
        let memory = &frame["memory"];
        let kinds = memory.as_object().expect("an object").iter();
        let sum =
            kinds.filter(|(kind, _)| *kind != "total").filter_map(|(_, bytes)| bytes.as_u64());
        assert_eq!(memory["total"].as_u64(), Some(sum.sum()), "{memory}");
        assert!(memory["targets"].as_u64() > Some(0) && memory["inference"].is_u64(), "{memory}");
        // A survey without faults.
        for refused in ["points_refused", "triangles_refused"] {
            assert_eq!(frame[refused], 0, "{frame}");
        }
        for (drawn, resident) in [("points_drawn", "points"), ("triangles_drawn", "triangles")] {
            let [drawn, resident] = [drawn, resident].map(|name| frame[name].as_u64());
            assert!(drawn > Some(0) && drawn <= resident, "{frame}");
        }
        let held = frame["budget"]["held"].as_bool().expect("settled");
        assert!(warned != held, "said where it is not held, and only there: {frame}");
        frame
    };
    let (cheapest, finest) = (frame("1"), frame("60000"));
    let (fastest, slowest) = (&cheapest["budget"], &finest["budget"]);
    assert_eq!((&fastest["held"], &slowest["held"]), (&false.into(), &true.into()));
    assert_eq!((&fastest["asked_ms"], &slowest["rung"]), (&1.0.into(), &0.into()));
    assert_eq!(fastest["rung"].as_u64().map(|rung| rung + 1), fastest["rungs"].as_u64());
    assert!(fastest["reached_ms"].as_f64() > Some(1.2), "{cheapest}");
    let (cheapest, finest) = (&cheapest["settings"], &finest["settings"]);
    assert!(cheapest["rigs"].as_u64() < finest["rigs"].as_u64());
    assert!(finest["points_share"] == 1.0 && finest["resolution"] == 1.0);
    let store = text(&place.street.store);
    let wrong = run(&["render", store, "--like", "x", "-o", "x.png", "--budget-ms", "0"]);
    assert_eq!(wrong.status.code(), Some(2));
}

fn a_server_gives_the_pixels_of_the_store(place: &Place) {
    let truth = json(&place.street.survey.join("truth/views.json"));
    let views: Vec<Value> = truth
        .as_array()
        .expect("a list")
        .iter()
        .take(2)
        .map(|view| {
            let keys = ["position", "heading_deg", "pitch_deg", "fov_deg"];
            keys.iter().map(|&key| (key.to_owned(), view[key].clone())).collect()
        })
        .collect();
    let path = place.file("views.json");
    std::fs::write(&path, Value::from(views).to_string()).expect("writable");

    let server = Server::start(&place.street.store);
    // In the store, the scene's name may be left out where there is only one.
    let sources = [text(&place.street.store).to_owned(), format!("{}/sample", server.url)];
    for (source, name) in sources.iter().zip(["here", "there"]) {
        succeed(&[
            "render",
            source,
            "--path",
            text(&path),
            "--size",
            "128x96",
            "--out",
            text(&place.file(&format!("{name}.png"))),
            "--report",
            text(&place.file(&format!("{name}.json"))),
        ]);
    }
    for number in 1..=2 {
        let here = picture(&place.file(&format!("here_{number:04}.png")));
        let there = picture(&place.file(&format!("there_{number:04}.png")));
        assert_eq!(here.dimensions(), (128, 96));
        assert!(here == there, "picture {number} differs between store and server");
    }
    let (here, there) = (json(&place.file("here.json")), json(&place.file("there.json")));
    for key in ["width", "height", "points", "triangles", "images", "bytes_received"] {
        assert!(here[key].as_u64().is_some_and(|n| n > 0), "{key}: {here}");
        assert_eq!(here[key], there[key], "{key}");
    }
    assert_eq!(here["coverage"], there["coverage"]);
    assert!(here["coverage"].as_f64().is_some_and(|share| share > 0.5 && share <= 1.0), "{here}");
    assert!(here["frame_ms"].as_f64() > Some(0.0) && here["first_frame_ms"].as_f64() > Some(0.0));
    assert!(here["adapter"].is_string());
    assert_eq!(here["frames"].as_array().map(Vec::len), Some(2));
}

/// A photograph's own camera, which sees its own scene through its own lens: what geometry
/// there is must show the photograph. Where the photograph itself is a source, its pixels
/// are blended with its neighbours', which see the same surfaces from metres away with an
/// error of some decimetres in the depth of what the lidar did not reach: a mean difference of
/// a tenth of the range is allowed, a picture shifted or turned has three times that.
fn a_photograph_is_rendered_like_itself(place: &Place) {
    let out = place.file("like.png");
    let photographs: Vec<PathBuf> = walk(&place.street.survey.join("images"));
    let report = place.file("like.json");
    let like = "101/602";
    let source = text(&place.street.store);
    succeed(&["render", source, "--like", like, "-o", text(&out), "--report", text(&report)]);
    let rendered = picture(&out);
    let own = photographs
        .iter()
        .find(|path| {
            let name = path.display().to_string();
            name.contains("101") && name.contains("602")
        })
        .unwrap_or_else(|| panic!("{like} is not among {photographs:?}"));
    let photograph = picture(own);
    assert_eq!(rendered.dimensions(), photograph.dimensions());
    let difference = |a: &RgbImage, b: &RgbImage| {
        let background = image::Rgb([178, 190, 202]);
        let pairs = a.pixels().zip(b.pixels()).filter(|(rendered, _)| **rendered != background);
        let (mut sum, mut count) = (0.0, 0.0);
        for (a, b) in pairs {
            for (a, b) in a.0.iter().zip(b.0) {
                sum += f64::from(a.abs_diff(b));
                count += 1.0;
            }
        }
        sum / count
    };
    let (own, turned) = (
        difference(&rendered, &photograph),
        difference(&rendered, &image::imageops::flip_horizontal(&photograph)),
    );
    println!("rendered like {like}: mean difference {own:.1} of 255, mirrored {turned:.1}");
    assert!(own < 25.0 && own < 0.6 * turned, "{own} {turned}");

    // Without it, fewer photographs are there.
    let images = json(&report)["images"].as_u64();
    let without = place.file("without.json");
    succeed(&[
        "render",
        source,
        "--like",
        like,
        "--without",
        "101",
        "-o",
        text(&place.file("without.webp")),
        "--report",
        text(&without),
    ]);
    assert!(json(&without)["images"].as_u64() < images);
    assert_eq!(picture(&place.file("without.webp")).dimensions(), photograph.dimensions());
}

fn what_is_asked_wrongly_is_said_in_one_line(place: &Place) {
    let (store, out) = (text(&place.street.store), place.file("never.png"));
    let out = text(&out);
    let unknown = fail(2, &["render", store, "--like", "101/606", "-o", out]);
    assert!(unknown.contains("101/606") && unknown.contains("101/602"), "{unknown}");
    let several = fail(2, &["render", store, "--like", "101", "-o", out]);
    assert!(several.contains("101/600"), "{several}");
    let view = "0,0,0,0,0";
    assert!(
        fail(2, &["render", store, "--view", view, "--without", "x*", "-o", out]).contains("x*")
    );
    assert!(fail(2, &["render", store, "--view", view, "-o", "frame.bmp"]).contains(".png"));
    let nowhere = place.file("no/frame.png");
    assert!(fail(2, &["render", store, "--view", view, "-o", text(&nowhere)]).contains("folder"));
    let absent = place.file("no-store");
    assert!(fail(2, &["info", text(&absent)]).contains("ingest"));
    fail(2, &["info", "ftp://host/scene"]);
    fail(2, &["info", "https://localhost/scene"]);
    // Nobody listens on port 1; that is no fault of what was typed.
    assert!(fail(1, &["info", "http://127.0.0.1:1/sample"]).contains("running"));
    let server = Server::start(&place.street.store);
    assert!(fail(2, &["info", &format!("{}/elsewhere", server.url)]).contains("elsewhere"));
    // What clap refuses.
    for arguments in [
        &["render", store, "-o", out][..],
        &["render", store, "--view", "1,2,3", "-o", out],
        &["render", store, "--view", view, "--size", "0x0", "-o", out],
        &["render", store, "--view", view, "--fov", "500", "-o", out],
    ] {
        assert_eq!(run(arguments).status.code(), Some(2), "{arguments:?}");
    }
    assert!(!Path::new(out).exists());
}

fn info_tells_what_there_is(place: &Place) {
    let source = place.street.store.join("sample");
    let info: Value =
        serde_json::from_str(&succeed(&["info", text(&source), "--json"])).expect("JSON");
    let server = Server::start(&source);
    let there: Value =
        serde_json::from_str(&succeed(&["info", &server.url, "--json"])).expect("JSON");
    assert_eq!(info, there);
    assert_eq!(info["name"], "sample");
    assert_eq!(info["crs"], "EPSG:2154");
    assert!(info["points"].as_u64() > Some(10_000) && info["images"].as_u64() > Some(10));
    let ids: Vec<&str> =
        info["image_ids"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert!(ids.contains(&"101/602") && ids.is_sorted(), "{ids:?}");
    assert!(info["first_time"].as_str() < info["last_time"].as_str());
    let text = succeed(&["info", text(&source)]);
    assert!(text.starts_with("sample\n") && text.contains("EPSG:2154"), "{text}");
}

fn walk(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() { files.extend(walk(&path)) } else { files.push(path) }
    }
    files
}

//! `flaneur eval` as a person runs it.

mod command;
mod street;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use command::{fail, json, run, succeed, text};
use serde_json::Value;
use street::SampleStreet;

/// The methods that all others are changes of, in the order of the reports.
const METHODS: [&str; 4] = ["nearest", "mesh", "points", "hybrid"];

/// The scene, and where reports go. Making a scene takes longer than looking at it, so one serves
/// all.
struct Place {
    street: SampleStreet,
    reports: PathBuf,
}

impl Place {
    fn file(&self, name: &str) -> PathBuf {
        self.reports.join(name)
    }

    fn store(&self) -> &str {
        text(&self.street.store)
    }
}

#[test]
fn a_scene_is_evaluated() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let street = runtime.block_on(SampleStreet::ingested("eval"));
    let reports = street.store.with_file_name("reports");
    std::fs::create_dir(&reports).expect("the build folder is writable");
    let place = Place { street, reports };
    held_out_photographs_are_rendered_from_the_others(&place);
    named_photographs_are_held_out(&place);
    views_are_compared_with_their_truth(&place);
    truth_that_does_not_fit_is_refused(&place);
    what_is_asked_wrongly_is_said(&place);
}

fn held_out_photographs_are_rendered_from_the_others(place: &Place) {
    let (report, page) = (place.file("every2.json"), place.file("every2.html"));
    let arguments = ["eval", place.store(), "--sources", "every:2", "--only", "10*", "--report"];
    let html = ["--html", text(&page)];
    let printed = succeed(&[&arguments[..], &[text(&report)], &html].concat());
    assert!(printed.contains("hybrid") && printed.contains("mean over 5 views"), "{printed}");
    let report = json(&report);
    // Of 101, 102 and 103 the second is held out, with all its cameras; the walk takes no part.
    assert_eq!(names(&report, "id"), (600..605).map(|camera| format!("102/{camera}")).collect());
    assert_eq!(report["settings"]["sources"], 10);
    assert_eq!(report["scene"], "sample");
    assert!(report["adapter"].as_str().is_some_and(|name| !name.is_empty()));
    for method in METHODS {
        assert!(names(&report, "method").contains(method), "{method}");
        let mean = &report["mean"][method];
        let of_views = |key: &str| {
            let values: Vec<f64> = rows(&report)
                .filter(|row| row["method"] == method)
                .map(|row| row[key].as_f64().unwrap_or_else(|| panic!("{key}: {row}")))
                .collect();
            assert_eq!(values.len(), 5, "{method}");
            (values.iter().sum::<f64>() / 5.0, values)
        };
        for (key, lowest, highest) in [
            ("psnr_db", 5.0, 60.0),
            ("ssim", -1.0, 1.0),
            ("rmse", 0.0, 1.0),
            ("inferred", 0.0, 1.0),
            ("unseen", 0.0, 1.0),
            ("masked", 0.0, 0.5),
            ("nearest_m", 0.5, 30.0),
        ] {
            let (of_views, values) = of_views(key);
            assert!(values.iter().all(|value| (lowest..=highest).contains(value)), "{key}");
            if key != "nearest_m" {
                let mean = mean[key].as_f64().unwrap_or_else(|| panic!("{key}: {mean}"));
                assert!((mean - of_views).abs() < 1e-9, "{method} {key}: {mean} {of_views}");
            }
        }
        // Only what shows geometry can be covered.
        for row in rows(&report).filter(|row| row["method"] == method) {
            match row["coverage"].as_f64() {
                Some(share) => {
                    assert!(method != "nearest" && (0.0..=1.0).contains(&share), "{row}");
                }
                None => assert_eq!(method, "nearest"),
            }
        }
        // PSNR and RMSE of a view say the same.
        for row in rows(&report) {
            let value = |key: &str| row[key].as_f64().expect("a number");
            assert!((value("psnr_db") + 20.0 * value("rmse").log10()).abs() < 1e-9, "{row}");
        }
    }
    // The nearest exposure is 8 m away, its picture unwarped: any rendering of this street, which
    // is known well, beats it by far. Mesh and points together show more of its structure than each
    // alone. (In PSNR the gaps between points come a tenth nearer where their depth is inferred
    // than where they show the mesh, which is only good to decimetres.)
    let psnr = |method: &str| report["mean"][method]["psnr_db"].as_f64().expect("a number");
    let ssim = |method: &str| report["mean"][method]["ssim"].as_f64().expect("a number");
    assert!(psnr("hybrid") > psnr("nearest") + 3.0 && ssim("hybrid") > ssim("nearest") + 0.1);
    assert!(ssim("hybrid") > ssim("mesh") && ssim("hybrid") > ssim("points"));
    assert!(psnr("hybrid") > psnr("mesh") && psnr("hybrid") > psnr("points") - 0.15);
    assert!(psnr("hybrid") > psnr("hybrid-without-depth-test"));
    // All are 8.1 to 8.3 m away.
    let bins = report["bins"].as_array().expect("a list");
    assert_eq!(bins.len(), 1, "{bins:?}");
    assert_eq!((&bins[0]["from_m"], &bins[0]["to_m"]), (&8.0.into(), &16.0.into()));
    assert_eq!(bins[0]["views"], 5);

    let page = std::fs::read_to_string(page).expect("written");
    assert!(page.starts_with("<!doctype html>") && page.ends_with("</html>\n"));
    assert!(page.contains("102/604") && page.contains("8–16 m") && page.contains("<svg"));
    let methods = report["settings"]["methods"].as_array().expect("a list").len();
    assert_eq!(page.matches("data:image/jpeg").count(), 5 * (1 + 2 * methods));
}

fn named_photographs_are_held_out(place: &Place) {
    let report = place.file("named.json");
    let arguments =
        ["eval", place.store(), "--hold-out", "102/602", "walk-001/f*", "--methods", "nearest"];
    succeed(&[&arguments[..], &["--report", text(&report)]].concat());
    let report = json(&report);
    assert_eq!(names(&report, "id"), ["102/602", "walk-001/front"].map(str::to_owned).into());
    assert_eq!(names(&report, "method"), ["nearest".to_owned()].into());
    assert_eq!(report["settings"]["sources"], 25);
    // Nothing was rendered, and no graphics device was needed.
    assert_eq!(report["adapter"], Value::Null);
    // The other faces of that sphere and the other cameras of that rig stand where these did.
    assert!(rows(&report).all(|row| row["nearest_m"].as_f64() < Some(0.5)), "{report}");
}

fn views_are_compared_with_their_truth(place: &Place) {
    let report = place.file("truth.json");
    let truth = place.street.survey.join("truth");
    let arguments = ["eval", place.store(), "--truth", text(&truth), "--methods", "hybrid,nearest"];
    succeed(&[&arguments[..], &["--report", text(&report)]].concat());
    let report = json(&report);
    let truth = json(&truth.join("views.json"));
    let views = truth.as_array().expect("a list");
    assert_eq!(report["settings"]["sources"], 27);
    assert_eq!(report["settings"]["targets"], views.len());
    for view in views {
        let row = rows(&report).find(|row| row["id"] == view["file"]).expect("evaluated");
        let [found, known] = [row, view].map(|of| of["nearest_m"].as_f64().expect("a number"));
        assert!((found - known).abs() < 0.01, "{found} {known}");
    }
    // What is near is there as a whole, and divided.
    let bins = report["bins"].as_array().expect("a list");
    let views_of = |wanted: &dyn Fn([Option<f64>; 2]) -> bool| -> u64 {
        let ends = |bin: &Value| [bin["from_m"].as_f64(), bin["to_m"].as_f64()];
        let bins = bins.iter().filter(|bin| wanted(ends(bin)));
        bins.map(|bin| bin["views"].as_u64().expect("a number")).sum()
    };
    let near = [Some(0.0), Some(8.0)];
    let divided = views_of(&|ends| ends != near && ends[1].is_some_and(|to_m| to_m <= 8.0));
    assert!(divided > 2 && views_of(&|ends| ends == near) == divided, "{bins:?}");
    assert_eq!(views_of(&|ends| ends != near), views.len() as u64, "{bins:?}");
    let psnr = |method: &str| report["mean"][method]["psnr_db"].as_f64().expect("a number");
    assert!(psnr("hybrid") > psnr("nearest") + 5.0, "{}", report["mean"]);
}

fn truth_that_does_not_fit_is_refused(place: &Place) {
    let folder = place.file("truth");
    std::fs::create_dir(&folder).expect("writable");
    image::RgbImage::new(32, 24).save(folder.join("small.png")).expect("writable");
    let refused = |view: &str| {
        let start = r#"[{"position":[651490,6861050,45],"heading_deg":0,"pitch_deg":0"#;
        let text_of = format!("{start}{view}}}]");
        std::fs::write(folder.join("views.json"), text_of).expect("writable");
        let report = place.file("never.json");
        fail(2, &["eval", place.store(), "--truth", text(&folder), "--report", text(&report)])
    };
    assert!(refused("").contains("names no picture"));
    assert!(refused(r#","file":"absent.png""#).contains("absent.png"));
    assert!(refused(r#","file":"../views.json""#).contains("same folder"));
    assert!(refused(r#","file":"/etc/hostname""#).contains("same folder"));
    let other = refused(r#","file":"small.png","width":64,"height":48"#);
    assert!(other.contains("64") && other.contains("32"), "{other}");
}

fn what_is_asked_wrongly_is_said(place: &Place) {
    let (store, report) = (place.store(), place.file("never.json"));
    let report = ["--report", text(&report)];
    let refused = |arguments: &[&str]| fail(2, &[&["eval", store], arguments, &report].concat());
    let unknown = refused(&["--hold-out", "101/609"]);
    assert!(unknown.contains("101/609") && unknown.contains("101/600"), "{unknown}");
    let nothing = refused(&["--sources", "every:2", "--only", "x*"]);
    assert!(nothing.contains("x*"), "{nothing}");
    let apart = refused(&["--hold-out", "101", "--only", "102", "103"]);
    assert!(apart.contains("takes part"), "{apart}");
    let alone = refused(&["--sources", "every:2", "--only", "101"]);
    assert!(alone.contains("stay sources"), "{alone}");
    let all = refused(&["--hold-out", "*/*"]);
    assert!(all.contains("none is left"), "{all}");
    let nowhere = place.file("no/report.json");
    let nowhere = ["eval", store, "--sources", "every:2", "--report", text(&nowhere)];
    assert!(fail(2, &nowhere).contains("folder"));
    // What clap refuses.
    for (arguments, said) in [
        (&["--sources", "every:0"][..], "keeps no photograph"),
        (&["--sources", "every:1"], "nothing is held out"),
        (&["--sources", "2"], "every:2"),
        (&["--sources", "every:2", "--methods", "magic"], "hybrid"),
        (&["--sources", "every:2", "--hold-out", "101"], "--hold-out"),
        (&[], "--sources"),
    ] {
        let output = run(&[&["eval", store], arguments, &report].concat());
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(said), "{arguments:?}: {stderr}");
    }
    assert!(!Path::new(report[1]).exists());
}

fn rows(report: &Value) -> impl Iterator<Item = &Value> {
    report["views"].as_array().expect("a list").iter()
}

fn names(report: &Value, key: &str) -> BTreeSet<String> {
    rows(report).map(|row| row[key].as_str().expect("text").to_owned()).collect()
}

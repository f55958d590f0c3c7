//! Programs in Python that walk through a street: the example, and one that looks closely at every
//! frame that comes.
//!
//! `make test` sets up their Python.

mod python;
mod served;
mod street;

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

use python::python;
use served::Served;
use street::SampleStreet;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A server that renders the street made for `name`, and `host:port` of it.
async fn serve(name: &str) -> (Served, String) {
    let street = SampleStreet::ingested(name).await;
    let served = Served::with([street.store.as_os_str()]);
    let address = served.url.trim_start_matches("http://").to_owned();
    (served, address)
}

/// What a program says, after checking that it ended well.
fn said(script: &str, arguments: &[&str], folder: &Path) -> String {
    let output = Command::new(python())
        .arg(Path::new(ROOT).join(script))
        .args(arguments.iter().map(OsStr::new))
        .current_dir(folder)
        // It would leave them beside the scripts.
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .expect("python starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{complaint}");
    text
}

#[tokio::test(flavor = "multi_thread")]
async fn the_example_streams_renders_and_walks() {
    let (served, address) = serve("python-example").await;
    let folder = tempfile::tempdir().expect("a folder");
    let text = said("examples/python/walk.py", &[&address], folder.path());
    assert!(text.starts_with("sample: EPSG:2154, 17 photographs"), "{text}");
    assert!(text.contains("building-"), "{text}");
    for name in ["picture.png", "walk_1.jpg", "walk_2.jpg", "walk_3.jpg"] {
        let picture = image::open(folder.path().join(name)).expect(name).into_rgb8();
        assert_eq!(picture.dimensions(), (640, 360), "{name}");
        let bright = picture.pixels().filter(|pixel| pixel.0[2] > 100).count();
        let share = bright as f64 / (640.0 * 360.0);
        assert!((0.05..0.95).contains(&share), "{name} shows {share} of light");
    }
    let points = std::fs::metadata(folder.path().join("points.npy")).expect("points").len();
    assert!(points > 24 * 100, "three doubles a point: {points} bytes");
    assert!(served.stop().success());
}

/// A minute, unless FLANEUR_TEST_NAVIGATE_SECONDS asks for less.
#[tokio::test(flavor = "multi_thread")]
async fn frames_keep_their_order_echo_and_finality() {
    let (served, address) = serve("python-navigate").await;
    let seconds = std::env::var("FLANEUR_TEST_NAVIGATE_SECONDS").unwrap_or("60".to_owned());
    let folder = Path::new(ROOT).join("tests");
    let text = said("tests/navigate.py", &[&address, "sample", &seconds], &folder);
    print!("{text}");
    assert!(text.contains("rounds"), "{text}");
    assert!(served.stop().success());
}

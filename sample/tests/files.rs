//! The sample as files: equal seeds give equal bytes, and nothing is left half done.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use flaneur_sample::{Progress, SampleError, SampleOptions, Stage, write_street};

const SMALL: SampleOptions = SampleOptions {
    seed: 3,
    length_m: 30.0,
    points: 20_000,
    exposures: 1,
    image_px: 64,
    spheres: 1,
    sphere_px: 48,
    views: 2,
    view_px: 48,
};

fn write(target: &Path, options: &SampleOptions) -> Result<(), SampleError> {
    write_street(target, options, &|_| {}, &AtomicBool::new(false)).map(|_| ())
}

/// Every file below a folder.
fn contents(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(root).expect("below").display().to_string();
                files.insert(name, fs::read(path).expect("a file"));
            }
        }
    }
    files
}

#[test]
fn equal_seeds_give_equal_bytes_on_any_number_of_threads() {
    let parent = tempfile::tempdir().expect("a folder");
    let on_threads = |threads: usize, name: &str, options: SampleOptions| {
        let target = parent.path().join(name);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| write(&target, &options)).expect("a sample");
        contents(&target)
    };
    let one = on_threads(1, "one", SMALL);
    let three = on_threads(3, "three", SMALL);
    assert_eq!(one.keys().collect::<Vec<_>>(), three.keys().collect::<Vec<_>>());
    for (name, bytes) in &one {
        assert!(*bytes == three[name], "{name} differs");
    }
    let other = on_threads(3, "other", SampleOptions { seed: 4, ..SMALL });
    assert!(one["footprints.geojson"] != other["footprints.geojson"], "the seed matters");
}

#[test]
fn a_folder_that_holds_something_is_left_alone() {
    let target = tempfile::tempdir().expect("a folder");
    fs::write(target.path().join("mine.txt"), "mine").expect("a file");
    let error = write(target.path(), &SMALL).expect_err("not empty");
    assert!(matches!(&error, SampleError::NotEmpty { path } if path == target.path()), "{error}");
    assert_eq!(contents(target.path()).len(), 1);
}

#[test]
fn stopping_leaves_nothing() {
    for stage in [Stage::Photographs, Stage::Points] {
        let parent = tempfile::tempdir().expect("a folder");
        let cancel = AtomicBool::new(false);
        let stop = |progress: Progress| {
            if progress.stage == stage {
                cancel.store(true, Ordering::Relaxed);
            }
        };
        let result = write_street(&parent.path().join("street"), &SMALL, &stop, &cancel);
        assert!(matches!(result, Err(SampleError::Cancelled)), "{result:?}");
        assert!(contents(parent.path()).is_empty());
        assert_eq!(fs::read_dir(parent.path()).expect("a folder").count(), 0);
    }
}

#[test]
fn progress_ends_at_its_totals_and_the_summary_agrees() {
    let parent = tempfile::tempdir().expect("a folder");
    let seen = Mutex::new(BTreeMap::new());
    let note = |progress: Progress| {
        let mut seen = seen.lock().expect("no panic");
        let best = seen.entry(progress.stage.name()).or_insert((0, 0));
        *best = (progress.done.max(best.0), progress.total);
    };
    let target = parent.path().join("street");
    let summary = write_street(&target, &SMALL, &note, &AtomicBool::new(false)).expect("a sample");
    let seen = seen.into_inner().expect("no panic");
    assert_eq!(summary.photographs, 6);
    assert_eq!(seen["photographs"], (6, 6));
    assert_eq!(seen["street"], (2, 2));
    assert_eq!(seen["held-out views"], (summary.views, summary.views));
    assert_eq!(seen["lidar points"].0, summary.points);
    let near = summary.points.abs_diff(SMALL.points) * 20 < SMALL.points;
    assert!(near, "{} points of {}", summary.points, SMALL.points);
}

#[test]
fn points_alone_need_no_photograph() {
    let parent = tempfile::tempdir().expect("a folder");
    let target = parent.path().join("street");
    write(&target, &SMALL.without_photographs()).expect("a sample");
    let files = contents(&target);
    let text = String::from_utf8(files["street.toml"].clone()).expect("text");
    assert!(text.contains("[[points]]") && !text.contains("[[panoramas]]"), "{text}");
    assert!(!files.keys().any(|name| name.ends_with(".jpg")));
}

#[test]
fn sizes_out_of_range_are_refused_by_name() {
    let parent = tempfile::tempdir().expect("a folder");
    let target = parent.path().join("street");
    for options in [
        SampleOptions { length_m: f64::NAN, ..SMALL },
        SampleOptions { length_m: 1e9, ..SMALL },
        SampleOptions { image_px: 100_000, ..SMALL },
        SampleOptions { points: u64::MAX, ..SMALL },
    ] {
        let error = write(&target, &options).expect_err("out of range");
        assert!(matches!(error, SampleError::Option { .. }), "{error}");
        assert!(!target.exists());
    }
    assert!(SampleOptions::scaled(1, f64::NAN).is_err());
    assert!(SampleOptions::scaled(1, 0.0).is_err());
}

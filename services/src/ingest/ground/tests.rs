use las::{Builder, Point, Writer};
use rand::{RngExt, SeedableRng};

use super::*;

fn job() -> (tempfile::TempDir, Job) {
    let folder = tempfile::tempdir().expect("a folder");
    let job = Job::new(folder.path(), 256 << 20);
    (folder, job)
}

fn local() -> Crs {
    Crs::parse("local", None).expect("local")
}

fn extent(min: (f64, f64), max: (f64, f64)) -> Bounds2 {
    Bounds2 { min: DVec2::from(min), max: DVec2::from(max) }
}

fn las(path: &Path, points: &[(DVec3, u8)]) -> PathBuf {
    let mut header = Builder::from((1, 4));
    header.point_format = las::point::Format::new(6).expect("format 6");
    let scale = |offset| las::Transform { scale: 0.001, offset };
    let offset = points.first().map_or(DVec3::ZERO, |p| p.0.round());
    header.transforms = las::Vector { x: scale(offset.x), y: scale(offset.y), z: scale(offset.z) };
    let mut writer =
        Writer::from_path(path, header.into_header().expect("a header")).expect("a file");
    for (position, class) in points {
        let mut point = Point { x: position.x, y: position.y, z: position.z, ..Point::default() };
        point.classification = las::point::Classification::new(*class).expect("not overlap");
        point.gps_time = Some(0.0);
        point.return_number = 1;
        point.number_of_returns = 1;
        writer.write_point(point).expect("in range");
    }
    writer.close().expect("written");
    path.to_owned()
}

/// A drive down a street at (651 000, 6 861 000): ground that falls by 3 % with a kerb, parked
/// cars, facades on both sides, trees, noise of 2 cm, and echoes from below the ground.
fn street(truth: impl Fn(DVec2) -> f64) -> Vec<(DVec3, u8)> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut points = Vec::new();
    let corner = DVec2::new(651_000.0, 6_861_000.0);
    for _ in 0..150_000 {
        let p = DVec2::new(rng.random_range(0.0..100.0), rng.random_range(-8.0..8.0));
        let noise = (rng.random_range(-1.0..1.0) + rng.random_range(-1.0..1.0)) * 0.02;
        let ground = truth(p);
        // A car of 4.5 × 1.8 m every 6 m hides the ground below it.
        let on_car = p.x % 6.0 < 4.5 && (2.5..4.3).contains(&p.y);
        let (height, class) = if on_car { (1.45, 1) } else { (0.0, 2) };
        points.push(((corner + p).extend(ground + height + noise), class));
    }
    for _ in 0..60_000 {
        let side = if rng.random_bool(0.5) { -8.0 } else { 8.0 };
        let p = DVec2::new(rng.random_range(0.0..100.0), side + rng.random_range(-0.05..0.05));
        points.push(((corner + p).extend(truth(p) + rng.random_range(0.1..15.0)), 6));
    }
    for _ in 0..200 {
        let p = DVec2::new(rng.random_range(0.0..100.0), rng.random_range(-7.0..7.0));
        points.push(((corner + p).extend(truth(p) - rng.random_range(0.6..4.0)), 1));
    }
    points
}

fn slope(p: DVec2) -> f64 {
    40.0 - 0.03 * p.x + if p.y.abs() > 5.0 { 0.12 } else { 0.0 }
}

/// Largest and root mean square difference from the truth inside of the street.
fn errors(ground: &Ground) -> (f64, f64) {
    let (mut largest, mut squares, mut count) = (0.0f64, 0.0, 0);
    for i in 1..200 {
        for j in -13..=13 {
            let p = DVec2::new(f64::from(i) * 0.5, f64::from(j) * 0.5);
            let found = ground.height(DVec2::new(651_000.0, 6_861_000.0) + p).expect("known");
            let error = (found - slope(p)).abs();
            largest = largest.max(error);
            squares += error * error;
            count += 1;
        }
    }
    (largest, (squares / f64::from(count)).sqrt())
}

#[test]
fn the_lowest_points_are_ground_and_nothing_else_is() {
    let (folder, job) = job();
    let file = las(&folder.path().join("street.las"), &street(slope));
    let spec = GroundSpec::Points { classes: None };
    let extent = extent((651_000.0, 6_860_992.0), (651_100.0, 6_861_008.0));
    let staged =
        ingest_ground(&job, Some(&spec), &local(), &[file], extent).expect("valid").expect("some");
    let (largest, rms) = errors(&Ground::open(&staged).expect("staged"));
    // The lowest of some hundred points a cell is 4 cm (twice the noise) and half a cell's fall
    // below the truth; beside the kerb and below the cars the gap adds its step of 12 cm.
    assert!(largest < 0.25, "a car or an echo came through: {largest} m");
    assert!(rms < 0.08, "{rms} m");
    assert!((0.02..0.1).contains(&staged.uncertainty_m), "{} m", staged.uncertainty_m);
}

#[test]
fn ground_classes_give_their_mean() {
    let (folder, job) = job();
    let file = las(&folder.path().join("street.las"), &street(slope));
    let spec = GroundSpec::Points { classes: Some(vec![2]) };
    let extent = extent((651_000.0, 6_860_992.0), (651_100.0, 6_861_008.0));
    let staged = ingest_ground(&job, Some(&spec), &local(), std::slice::from_ref(&file), extent)
        .expect("valid")
        .expect("some");
    let (largest, rms) = errors(&Ground::open(&staged).expect("staged"));
    assert!(largest < 0.15 && rms < 0.03, "{largest} m, {rms} m");

    let spec = GroundSpec::Points { classes: Some(vec![11]) };
    let error =
        ingest_ground(&job, Some(&spec), &local(), &[file], extent).expect_err("no class 11");
    assert!(error.to_string().contains("the classes are [1, 2, 6]"), "{error}");
}

#[test]
fn a_list_is_joined_by_triangles_and_continued() {
    let (folder, job) = job();
    let path = folder.path().join("dtm.json");
    let plane = |p: DVec2| 35.0 + 0.02 * (p.x - 651_000.0) - 0.01 * (p.y - 6_861_000.0);
    let places = [(0.0, 0.0), (90.0, 5.0), (85.0, 70.0), (5.0, 80.0), (40.0, 33.0)];
    let list: Vec<String> = places
        .iter()
        .map(|(e, n)| DVec2::new(651_000.0 + e, 6_861_000.0 + n))
        .map(|p| format!(r#"{{"e":{},"n":{},"h":{},"id":1}}"#, p.x, p.y, plane(p)))
        .collect();
    std::fs::write(&path, format!("[{}]", list.join(","))).expect("a file");
    let spec = GroundSpec::PointsJson { path };
    let extent = extent((650_500.0, 6_861_000.0), (651_090.0, 6_861_080.0));
    let staged =
        ingest_ground(&job, Some(&spec), &local(), &[], extent).expect("valid").expect("some");
    let ground = Ground::open(&staged).expect("staged");
    for inside in [(30.0, 20.0), (45.5, 40.25), (80.0, 10.0)] {
        let p = DVec2::new(651_000.0 + inside.0, 6_861_000.0 + inside.1);
        let found = ground.height(p).expect("inside");
        // A plane survives triangles and grid; f32 holds 40 m to 4 µm.
        assert!((found - plane(p)).abs() < 1e-5, "{found} against {}", plane(p));
    }
    let beside = ground.height(DVec2::new(650_950.0, 6_861_010.0)).expect("within reach");
    assert!((beside - plane(DVec2::new(651_000.0, 6_861_000.0))).abs() < 1.0);
    assert_eq!(ground.height(DVec2::new(650_800.0, 6_861_010.0)), None, "200 m from any height");
}

#[test]
fn a_constant_covers_the_extent() {
    let (_folder, job) = job();
    let spec = GroundSpec::Constant { height_m: 12.5 };
    let extent = extent((-3.0, 4.0), (5000.0, 90.0));
    let staged =
        ingest_ground(&job, Some(&spec), &local(), &[], extent).expect("valid").expect("some");
    let ground = Ground::open(&staged).expect("staged");
    for p in [extent.min, extent.max, DVec2::new(777.7, 33.3)] {
        assert_eq!(ground.height(p), Some(12.5), "{p}");
    }
    let nothing = ingest_ground(&job, Some(&spec), &local(), &[], Bounds2::EMPTY).expect("valid");
    assert_eq!(nothing, None, "an empty street has no ground");
}

#[test]
fn bad_lists_are_named() {
    let (folder, job) = job();
    let path = folder.path().join("dtm.json");
    let extent = extent((0.0, 0.0), (10.0, 10.0));
    let refusal = |text: &str| {
        std::fs::write(&path, text).expect("a file");
        let spec = GroundSpec::PointsJson { path: path.clone() };
        let error = ingest_ground(&job, Some(&spec), &local(), &[], extent).expect_err(text);
        error.to_string().replace(&folder.path().display().to_string(), "")
    };
    assert!(refusal("[]").contains("the list is empty"));
    assert!(refusal(r#"[{"e":1,"n":2,"h":3}"#).contains("line 1, column"));
    assert!(refusal(r#"[{"e":1,"n":2}]"#).contains("missing field `h`"));
    assert!(refusal(r#"[{"e":1e300,"n":2,"h":3}]"#).contains("out of range"));
    assert!(refusal(r#"[{"e":1e6,"n":2,"h":3}]"#).contains("CRS"), "far from the street");
    assert!(refusal("not json").contains("dtm.json"));
}

#[test]
fn gaps_are_filled_and_known_heights_kept() {
    let frame = Frame { origin: DVec2::ZERO, spacing_m: 1.0, columns: 90, rows: 70 };
    let plane = |node: usize| (frame.position(node).x * 0.05 + 10.0) as f32;
    let mut grid = frame.grid();
    let hole = |node: usize| {
        let p = frame.position(node);
        (20.0..50.0).contains(&p.x) && (20.0..45.0).contains(&p.y)
    };
    (0..frame.nodes()).filter(|i| !hole(*i)).for_each(|i| grid.heights[i] = plane(i));
    fill::fill(&mut grid);
    for (node, height) in grid.heights.iter().enumerate() {
        let error = (height - plane(node)).abs();
        // Across 30 m the plane rises by 1.5 m; the fill is not linear, but stays within its rim.
        let allowed = if hole(node) { 0.5 } else { 0.0 };
        assert!(error <= allowed, "node {node}: {error} m off");
    }
}

fn data(path: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(path);
    if !path.exists() {
        eprintln!("skipped: {} is absent", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn karlsruhe_from_its_lidar() {
    let Some(file) = data("karlsruhe/points.laz") else { return };
    let (_folder, job) = job();
    let spec = GroundSpec::Points { classes: None };
    let mut bounds = Bounds2::EMPTY;
    let mut points = Vec::new();
    crate::ingest::points::scan(std::slice::from_ref(&file), &job, |chunk| {
        chunk.positions.iter().for_each(|p| bounds.include(p.truncate()));
        points.extend_from_slice(&chunk.positions);
        Ok(())
    })
    .expect("valid");
    let staged =
        ingest_ground(&job, Some(&spec), &local(), &[file], bounds).expect("valid").expect("some");
    let ground = Ground::open(&staged).expect("staged");
    // Where the ground is right, very few points lie below it, and many lie just on it.
    let above: Vec<f64> =
        points.iter().filter_map(|p| Some(p.z - ground.height(p.truncate())?)).collect();
    let share = |from: f64, to: f64| {
        above.iter().filter(|h| (from..to).contains(*h)).count() as f64 / above.len() as f64
    };
    eprintln!(
        "karlsruhe: {:?}, spacing {} m, uncertainty {:.3} m; below −0.3 m {:.4}, within 0.15 m {:.3}",
        staged.bounds,
        staged.spacing_m,
        staged.uncertainty_m,
        share(-1e9, -0.3),
        share(-0.15, 0.15)
    );
    assert!(share(-1e9, -0.3) < 0.01, "{} of the points lie below the ground", share(-1e9, -0.3));
    assert!(share(-0.15, 0.15) > 0.2, "{} lie on it", share(-0.15, 0.15));
    // The street and the yards beside it rise from −1.6 m to 0.2 m; echoes reach down to −16 m,
    // walls and trees up to 5 m. At the rim of what the lidar saw there may be some of these.
    let mut heights: Vec<f32> = ground.0.heights.iter().copied().filter(|h| !h.is_nan()).collect();
    heights.sort_by(f32::total_cmp);
    let at = |q: f64| heights[((heights.len() - 1) as f64 * q) as usize];
    eprintln!("karlsruhe: nodes {:?}", [0.0, 0.01, 0.1, 0.5, 0.9, 0.95, 0.99, 1.0].map(at));
    assert!(at(0.0) > -3.0 && at(0.01) > -2.0 && at(0.95) < 1.0, "{} to {}", at(0.0), at(1.0));
}

#[test]
fn delft_classes_and_lowest_points_agree() {
    let files: Vec<PathBuf> = ["delft/ahn3_cropped_1.laz", "delft/ahn3_cropped_2.laz"]
        .into_iter()
        .filter_map(data)
        .collect();
    if files.len() < 2 {
        return;
    }
    let mut bounds = Bounds2::EMPTY;
    let (_folder, job) = job();
    crate::ingest::points::scan(&files, &job, |chunk| {
        chunk.positions.iter().for_each(|p| bounds.include(p.truncate()));
        Ok(())
    })
    .expect("valid");
    let crs = Crs::parse("EPSG:28992", None).expect("known");
    let make = |classes| {
        let spec = GroundSpec::Points { classes };
        let staged = ingest_ground(&job, Some(&spec), &crs, &files, bounds).expect("valid");
        let staged = staged.expect("some");
        eprintln!("delft: {:?}, uncertainty {:.3} m", staged.bounds, staged.uncertainty_m);
        Ground::open(&staged).expect("staged")
    };
    let (by_class, by_lowest) = (make(Some(vec![2])), make(None));
    let mut differences = Vec::new();
    crate::ingest::points::scan(&files, &job, |chunk| {
        for (p, class) in chunk.positions.iter().zip(&chunk.classes) {
            if *class == 2
                && let (Some(a), Some(b)) =
                    (by_class.height(p.truncate()), by_lowest.height(p.truncate()))
            {
                differences.push((b - a).abs());
            }
        }
        Ok(())
    })
    .expect("valid");
    differences.sort_by(f64::total_cmp);
    let at = |q: f64| differences[(differences.len() as f64 * q) as usize];
    eprintln!("delft: lowest against class 2: median {:.3}, 95 % {:.3} m", at(0.5), at(0.95));
    assert!(at(0.5) < 0.15 && at(0.95) < 1.0, "median {}, 95 % {}", at(0.5), at(0.95));
}

#[test]
fn paris_from_its_list() {
    let Some(path) = data("paris/dtm.json") else { return };
    let (_folder, job) = job();
    let crs = Crs::parse("EPSG:2154", None).expect("known");
    let samples = list::read(&job, &path).expect("valid");
    let spec = GroundSpec::PointsJson { path };
    let extent = extent((651_100.0, 6_861_250.0), (651_450.0, 6_861_450.0));
    let staged = ingest_ground(&job, Some(&spec), &crs, &[], extent).expect("valid").expect("some");
    let ground = Ground::open(&staged).expect("staged");
    let mut worst = 0.0f64;
    for sample in &samples {
        if let Some(height) = ground.height(sample.truncate()) {
            worst = worst.max((height - sample.z).abs());
        }
    }
    eprintln!("paris: {} heights, {:?}, worst {worst:.3} m", samples.len(), staged.bounds);
    // Sampling the triangles at nodes 1 m apart moves a height by at most its local step.
    assert!(worst < 0.6, "{worst} m");
    assert!(staged.bounds.min.z > 30.0 && staged.bounds.max.z < 60.0);
}

//! The real surveys, end to end: skipped, by name, where they are absent.

use std::path::{Path, PathBuf};

use flaneur_scene::{ImageId, Panorama, PosedCamera, Region};
use glam::{DVec2, DVec3};
use object_store::memory::InMemory;
use object_store::path::Path as StorePath;
use object_store::{ObjectStoreExt, PutPayload};

pub(super) mod survey;

use super::*;
use crate::ingest::street::Street;
use crate::layers::panoramas;

/// The folder of a real survey, or `None` with a word on what is skipped.
fn survey(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(name);
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: {} is absent", path.display());
    None
}

async fn ingest(name: &str) -> Option<(StagedPanoramas, Job, Vec<Panorama>, tempfile::TempDir)> {
    let street = Street::open(&survey(name)?.join("street.toml"), false).expect("a street");
    let crs = Crs::parse(&street.scene.crs, street.scene.geographic_origin).expect("a CRS");
    let work = tempfile::tempdir().expect("a work folder");
    let job = Job::new(work.path(), 1 << 30);
    // The poses' formulas are what is tested here.
    let mut specs = street.panoramas;
    for spec in &mut specs {
        match spec {
            PanoramasSpec::Itowns(spec) => spec.refine_poses = false,
            PanoramasSpec::Colmap(spec) => spec.refine_poses = false,
            PanoramasSpec::Equirectangular(_) => {}
        }
    }
    let staged = ingest_panoramas(&job, &specs, &crs).expect("ingested");
    let staged = staged.expect("panoramas");
    let bytes = std::fs::read(&staged.table).expect("the table");
    let (store, path, size) = (InMemory::new(), StorePath::from("p.fgb"), bytes.len() as u64);
    store.put(&path, PutPayload::from(bytes)).await.expect("stored");
    let panoramas = panoramas::read(std::sync::Arc::new(store), path, size, Region::All).await;
    Some((staged, job, panoramas.expect("read back"), work))
}

fn camera(panoramas: &[Panorama], id: &str) -> PosedCamera {
    let id: ImageId = id.parse().expect("an image");
    let all = panoramas.iter().filter(|p| p.id == id.panorama());
    let mut photographs = all.flat_map(|p| p.photographs().expect("valid names"));
    photographs.find(|(found, _)| *found == id).expect("the photograph").1
}

#[tokio::test]
async fn paris() {
    let Some((staged, job, panoramas, _work)) = ingest("paris").await else { return };
    assert_eq!((staged.panoramas, staged.images), (44, 220));
    assert_eq!(job.warnings().counts().get("absent-image"), Some(&30));
    // Five levels an image and two masks.
    assert_eq!(staged.objects.len(), 220 * 5 + 2);
    let front = panoramas.iter().find(|p| p.id == "490").expect("panorama 490");
    let masks: Vec<bool> = front.cameras.iter().map(|c| c.mask.is_some()).collect();
    assert_eq!(masks, [false, true, false, true, false]);
    assert_eq!(front.time.as_deref().map(|t| &t[..10]), Some("2014-06-16"));
    // 2.28 m above the published road.
    assert!((staged.bounds.min.z - 41.0).abs() < 2.0, "{:?}", staged.bounds);

    check_projections(&panoramas, 0.01);
}

/// World points with the pixels and depths at which another implementation sees them.
fn check_projections(panoramas: &[Panorama], tolerance_px: f64) {
    let Some(folder) = survey("paris") else { return };
    let text = std::fs::read_to_string(folder.join("check_projection.csv")).expect("the oracle");
    let mut worst: f64 = 0.0;
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 42);
    for row in rows {
        let number = |i: usize| row[i].parse::<f64>().expect("a number");
        let camera = camera(panoramas, &format!("{}/{}", row[0], row[1]));
        let point = DVec3::new(number(2), number(3), number(4));
        let (pixel, depth) = camera.project(point).expect("in front of the camera");
        let error = pixel.distance(DVec2::new(number(5), number(6)));
        assert!(error < tolerance_px, "{row:?}: {pixel}, off by {error} px");
        assert!((depth - number(7)).abs() < 1e-3, "{row:?}: depth {depth}");
        worst = worst.max(error);
    }
    println!("worst of 42 projections: {worst:.4} px");
}

#[tokio::test]
async fn karlsruhe() {
    let Some((staged, job, panoramas, _work)) = ingest("karlsruhe").await else { return };
    assert_eq!((staged.panoramas, staged.images), (102, 102));
    assert!(job.warnings().counts().is_empty());
    // Both cameras of the first frame look the same way, half a metre apart.
    let (left, right) = (camera(&panoramas, "02_000000/2"), camera(&panoramas, "03_000000/3"));
    assert!(left.forward().distance(right.forward()) < 1e-9);
    let baseline = left.cam_from_world(right.centre);
    assert!((baseline - DVec3::new(0.5327, -0.0028, 0.0)).length() < 1e-3, "{baseline}");
    // Cars drive level: the image's down is the world's down, within the road's slope.
    let down = left.cam_from_world.transpose() * DVec3::Y;
    assert!(down.z < -0.99, "{down}");
}

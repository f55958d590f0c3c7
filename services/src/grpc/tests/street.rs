//! A small street in memory, made with the layers' own writers and published like any other.

use std::sync::Arc;

use flaneur_scene::{
    Bounds3, Footprint, GpsTimeKind, Intrinsics, Lens, Mask, OctreeCube, Panorama, PointSource,
    Polygon, Projection, RigCamera, Station, StoredImage, world_from_rig,
};
use glam::{DMat3, DVec2, DVec3, UVec2};
use object_store::ObjectStore;
use object_store::memory::InMemory;
use object_store::path::Path;
use tempfile::TempDir;

use crate::crs::Crs;
use crate::layers::AttributeColumns;
use crate::layers::copc::{deep_tree, write_copc};
use crate::layers::footprints::FootprintsWriter;
use crate::layers::ground::{self, GroundGrid};
use crate::layers::panoramas::{self, image_path, mask_path};
use crate::layers::stations;
use crate::store::{
    FileEntry, FootprintsLayer, GroundLayer, Manifest, PanoramasLayer, PointsLayer, SceneFolder,
    Store,
};

/// Name of the scene.
pub(super) const SCENE: &str = "rue d'été";

/// Points of every node.
pub(super) const NODE_POINTS: u32 = 3;

/// Bytes of level 0 of the images of panoramas 1 and 2: more than two parts.
const LARGE_IMAGE_BYTES: usize = 2_500_000;

/// A memory store that holds the street.
pub(super) async fn street() -> Arc<dyn ObjectStore> {
    let objects: Arc<dyn ObjectStore> = Arc::new(InMemory::new());
    publish(&store(objects.clone())).await;
    objects
}

/// The store whose objects these are.
pub(super) fn store(objects: Arc<dyn ObjectStore>) -> Store {
    Store::new("memory:///", objects, Path::ROOT)
}

/// Twenty buildings, 10 m apart along the street.
pub(super) fn footprints() -> Vec<Footprint> {
    let building = |i: u32| {
        let corner = DVec2::new(f64::from(i) * 10.0, 5.0);
        let ring = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|d| corner + d * 8.0);
        Footprint {
            id: format!("b{i}"),
            polygons: vec![Polygon { rings: vec![ring.to_vec()] }],
            base_m: 30.0,
            height_m: 12.0 + f64::from(i),
            uncertainty_m: 0.5,
            attributes: format!(r#"{{"étages":{i}}}"#),
        }
    };
    (0..20).map(building).collect()
}

/// Forty rigs of two cameras, 5 m apart along the street; every second one has masks.
pub(super) fn rigs() -> Vec<Panorama> {
    let size = UVec2::new(64, 48);
    let intrinsics = Intrinsics { fx: 50.0, fy: 51.0, cx: 32.5, cy: 23.5 };
    let rig = |i: u32| {
        let camera = |id: &str, turn| RigCamera {
            id: id.into(),
            position_in_rig: DVec3::new(0.1, 0.0, 0.0),
            cam_from_rig: DMat3::from_rotation_x(turn),
            projection: Projection::Pinhole(Lens::pinhole(size, intrinsics)),
            levels: (0..2).map(|level| stored(&image(&format!("p{i}"), id, level))).collect(),
            mask: i
                .is_multiple_of(2)
                .then(|| Mask { name: "vehicle".into(), image: stored(&mask()) }),
            version: "v1".into(),
        };
        Panorama {
            id: format!("p{i}"),
            position: DVec3::new(f64::from(i) * 5.0, 1.0 / 3.0, 32.0),
            world_from_rig: world_from_rig(0.1 * f64::from(i), 0.0, 0.0),
            time: None,
            uncertainty_m: 0.2,
            cameras: vec![camera("front", 1.5), camera("left", 1.6)],
        }
    };
    (0..40).map(rig).collect()
}

/// The stored bytes of a level of an image: nobody decodes them here, so any will do.
pub(super) fn image(panorama: &str, camera: &str, level: u32) -> Vec<u8> {
    let seed = panorama
        .bytes()
        .chain(camera.bytes())
        .fold(level, |seed, byte| seed.wrapping_mul(31).wrapping_add(u32::from(byte)));
    let large = level == 0 && ["p1", "p2"].contains(&panorama);
    let length = if large { LARGE_IMAGE_BYTES } else { 1000 };
    (0..length as u32).map(|i| (i.wrapping_mul(seed | 1) >> 7) as u8).collect()
}

fn stored(bytes: &[u8]) -> StoredImage {
    StoredImage { bytes: bytes.len() as u64, crc32: crc32fast::hash(bytes) }
}

/// Where the drive was, in steps that are sent without loss.
pub(super) fn stations() -> Vec<Station> {
    let station = |i: u32| Station {
        time_s: 0.125 * f64::from(i),
        position: DVec3::new(f64::from(i), 0.5, 32.0),
        correction: flaneur_scene::StationCorrection::default(),
    };
    (0..50).map(station).collect()
}

/// The stored bytes of the one mask.
pub(super) fn mask() -> Vec<u8> {
    b"a mask".to_vec()
}

async fn publish(store: &Store) {
    let folder = store.scene_folder(SCENE).expect("a valid name");
    let work = tempfile::tempdir().expect("a folder");
    let mut manifest = crate::store::tests::manifest(SCENE);
    manifest.scene.footprints = 20;
    manifest.footprints = Some(FootprintsLayer { file: put_footprints(&folder, &work).await });
    let grid = grid();
    manifest.scene.ground = Some(grid.layout());
    manifest.ground = Some(GroundLayer { file: put_ground(&folder, &work, &grid).await });
    manifest.scene.panoramas = 40;
    manifest.scene.images = 80;
    manifest.panoramas =
        Some(PanoramasLayer { file: put_panoramas(&folder, &work).await, delivered: None });
    put_points(&folder, &work, &mut manifest).await;
    folder.put_manifest(&manifest).await.expect("memory");
}

async fn put_footprints(folder: &SceneFolder, work: &TempDir) -> FileEntry {
    let mut columns = AttributeColumns::default();
    for footprint in footprints() {
        columns.observe(&serde_json::from_str(&footprint.attributes).expect("an object"));
    }
    let crs = Crs::parse("local", None).expect("local");
    let mut writer = FootprintsWriter::new(&crs, columns).expect("room");
    for footprint in footprints() {
        writer.push(&footprint).expect("room");
    }
    let file = work.path().join("footprints.fgb");
    writer.finish(&file).expect("room");
    put(folder, work, "footprints.1.fgb", &std::fs::read(file).expect("written")).await
}

fn grid() -> GroundGrid {
    let (columns, rows) = (200, 70);
    GroundGrid {
        origin: DVec2::new(0.0, -20.0),
        spacing_m: 1.0,
        columns,
        rows,
        heights: (0..columns * rows).map(|i| 30.0 + (i % 7) as f32).collect(),
        uncertainty_m: 0.1,
    }
}

async fn put_ground(folder: &SceneFolder, work: &TempDir, grid: &GroundGrid) -> FileEntry {
    let file = work.path().join("ground.tif");
    ground::write(&file, grid, &Crs::parse("local", None).expect("local")).expect("room");
    put(folder, work, "ground.1.tif", &std::fs::read(file).expect("written")).await
}

async fn put_panoramas(folder: &SceneFolder, work: &TempDir) -> FileEntry {
    let rigs = rigs();
    for rig in &rigs {
        for camera in &rig.cameras {
            for level in 0..camera.level_count() {
                let path = image_path(&rig.id, &camera.id, &camera.version, level);
                put(folder, work, &path, &image(&rig.id, &camera.id, level)).await;
            }
        }
    }
    put(folder, work, &mask_path("vehicle"), &mask()).await;
    let mut table = Vec::new();
    panoramas::write(&mut table, &rigs, None).expect("memory");
    put(folder, work, "panoramas.1.fgb", &table).await
}

async fn put_points(folder: &SceneFolder, work: &TempDir, manifest: &mut Manifest) {
    let file = work.path().join("points.copc.laz");
    write_copc(&file, &deep_tree(), NODE_POINTS);
    let bytes = std::fs::read(file).expect("written");
    for name in ["drive", "air"] {
        let file = put(folder, work, &format!("points/{name}.1.copc.laz"), &bytes).await;
        let mut stations = None;
        if name == "drive" {
            let bytes = stations::encode(&self::stations()).expect("ascending");
            stations = Some(put(folder, work, "points/drive.1.stations.json", &bytes).await);
        }
        manifest.points.push(PointsLayer { source: name.into(), file, stations });
        manifest.scene.point_sources.push(PointSource {
            name: name.into(),
            point_count: deep_tree().len() as u64 * u64::from(NODE_POINTS),
            bounds: Bounds3 { min: DVec3::splat(-8.0), max: DVec3::splat(8.0) },
            cube: OctreeCube { centre: DVec3::ZERO, half_size_m: 8.0, spacing_m: 1.0 },
            point_format: 6,
            record_length: 30,
            scale: DVec3::splat(0.001),
            offset: DVec3::ZERO,
            laszip_vlr: vec![3],
            extra_bytes_vlr: vec![],
            gps_time: GpsTimeKind::Adjusted,
        });
    }
}

async fn put(folder: &SceneFolder, work: &TempDir, path: &str, bytes: &[u8]) -> FileEntry {
    let file = work.path().join("object");
    std::fs::write(&file, bytes).expect("room");
    folder.publish_object(path, &file, &|_| ()).await.expect("memory");
    FileEntry { path: path.into(), bytes: bytes.len() as u64, blake3: path.into() }
}

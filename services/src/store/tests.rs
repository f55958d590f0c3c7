//! One suite for every kind of store: a folder, memory, and an S3 server.

mod s3;

use std::sync::atomic::{AtomicU64, Ordering};

use flaneur_scene::{Bounds3, SceneInfo};
use glam::DVec3;

use super::*;

/// A manifest of a scene with nothing in it.
pub(crate) fn manifest(name: &str) -> Manifest {
    Manifest {
        format: Manifest::FORMAT,
        scene: SceneInfo {
            name: name.into(),
            crs: "local".into(),
            geographic_origin: None,
            origin: DVec3::ZERO,
            bounds: Bounds3 { min: DVec3::ZERO, max: DVec3::ONE },
            footprints: 0,
            panoramas: 0,
            images: 0,
            ground: None,
            point_sources: vec![],
            version: String::new(),
        },
        fingerprint: String::new(),
        footprints: None,
        ground: None,
        panoramas: None,
        points: vec![],
        warnings: vec![],
        generator: "test".into(),
    }
}

#[tokio::test]
async fn a_folder_is_a_store() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("not/yet/there");
    let url = path.to_str().expect("text");
    let store = Store::open_with(url, []).expect("a folder that can be made");
    suite(&store).await;
    let direct = Store::open_existing(&format!("{url}/älter straße")).expect("a scene's folder");
    let found = direct.as_scene().await.expect("readable");
    assert!(
        found.is_some_and(|(above, name)| above.folder == Some(path) && name == "älter straße")
    );
}

#[tokio::test]
async fn memory_is_a_store() {
    suite(&Store::open_with("memory:///", []).expect("memory")).await;
    suite(&Store::open_with("memory:///deep/er", []).expect("memory")).await;
}

#[tokio::test]
async fn s3_is_a_store() {
    let server = s3::S3Server::start("bucket").await;
    suite(&server.store("s3://bucket")).await;
    suite(&server.store("s3://bucket/deep/er/")).await;
}

#[tokio::test]
async fn s3_refuses_wrong_credentials_with_a_remedy() {
    let server = s3::S3Server::start("bucket").await;
    let mut settings = server.settings();
    settings.retain(|(name, _)| name != "aws_secret_access_key");
    settings.push(("aws_secret_access_key".into(), "wrong".into()));
    let store = Store::open_with("s3://bucket", settings).expect("opens");
    let error = store.scenes().await.expect_err("refused").to_string();
    assert!(error.contains("permission") || error.contains("credentials"), "{error}");
}

#[test]
fn a_version_changes_with_the_content_but_not_with_the_name() {
    let version = |name: &str, change: fn(&mut Manifest)| {
        let mut manifest = manifest("street");
        change(&mut manifest);
        let text = serde_json::to_vec(&manifest).expect("memory");
        Manifest::parse(name, &text).expect("sound").scene.version
    };
    let first = version("street", |_| ());
    assert_eq!(first, version("copied", |_| ()));
    assert_eq!(first, version("street", |m| m.scene.version = "what it was before".into()));
    let ground = |m: &mut Manifest, blake3: &str| {
        let file = FileEntry { path: "ground.tif".into(), bytes: 9, blake3: blake3.into() };
        m.ground = Some(GroundLayer { file });
    };
    let changed: [fn(&mut Manifest); 4] = [
        |m| m.scene.origin.x = 1.0,
        |m| m.scene.images = 1,
        |m| m.scene.geographic_origin = Some([1.0, 2.0, 3.0]),
        |m| m.scene.crs = "EPSG:2154".into(),
    ];
    let mut versions: Vec<String> =
        changed.into_iter().map(|change| version("street", change)).collect();
    for blake3 in ["a", "b"] {
        let mut manifest = manifest("street");
        ground(&mut manifest, blake3);
        let text = serde_json::to_vec(&manifest).expect("memory");
        versions.push(Manifest::parse("street", &text).expect("sound").scene.version);
    }
    versions.push(first);
    versions.sort();
    versions.dedup();
    assert_eq!(versions.len(), 7);
}

#[test]
fn a_manifest_of_another_format_says_what_to_do() {
    let text = br#"{"format": 1, "scene": "of another shape"}"#;
    let error = Manifest::parse("street", text).expect_err("old").to_string();
    assert!(error.contains("format 1") && error.contains("ingest the survey again"), "{error}");
}

/// What every store must do. The store is empty at first.
async fn suite(store: &Store) {
    assert_eq!(store.scenes().await.expect("an empty store"), [""; 0]);
    let folder = store.scene_folder("älter straße").expect("a valid name");
    assert!(folder.manifest().await.expect("readable").is_none());
    publish_small_and_large(&folder).await;
    assert_eq!(store.scenes().await.expect("readable"), [""; 0], "no manifest, no scene");

    let catalog = Catalog::open([store.clone()]).await.expect("readable");
    let missing = catalog.scene("älter straße").await.expect_err("not yet published");
    assert!(matches!(missing, StoreError::NoScene { .. }), "{missing}");

    folder.put_manifest(&manifest("another name")).await.expect("writable");
    assert_eq!(store.scenes().await.expect("readable"), ["älter straße"]);
    let scene = catalog.scene("älter straße").await.expect("published");
    assert_eq!(scene.manifest.scene.name, "älter straße", "the folder names the scene");

    republish(&catalog, &folder, &scene).await;

    // Only what has a manifest is a scene.
    let stray = store.scene_folder("stray").expect("a valid name");
    let file = tempfile::NamedTempFile::new().expect("a file");
    stray.publish_object("points/a.copc.laz", file.path(), &|_| ()).await.expect("writable");
    assert_eq!(catalog.names().await.expect("readable"), ["älter straße"]);

    folder.delete("points/large 1.copc.laz").await.expect("writable");
    folder.delete("points/large 1.copc.laz").await.expect("deleting twice is fine");
    assert!(folder.head("points/large 1.copc.laz").await.expect("readable").is_none());
}

async fn publish_small_and_large(folder: &SceneFolder) {
    let local = tempfile::tempdir().expect("a folder");
    // More than two parts of a multipart upload, and not whole ones.
    let large: Vec<u8> = (0..17_000_003u32).flat_map(|i| (i as u8).to_le_bytes()).collect();
    for (path, bytes) in
        [("empty.tif", &[][..]), ("a b/ü%20.jpg", b"jpeg"), ("points/large 1.copc.laz", &large)]
    {
        let file = local.path().join("file");
        std::fs::write(&file, bytes).expect("writable");
        let told = AtomicU64::new(0);
        let tell = |n| {
            told.fetch_add(n, Ordering::Relaxed);
        };
        folder.publish_object(path, &file, &tell).await.expect("writable");
        assert_eq!(told.into_inner(), bytes.len() as u64);
        let size = folder.head(path).await.expect("readable").expect("published").size;
        assert_eq!(size, bytes.len() as u64);
    }
    let range = 8_388_600..8_388_700;
    let got = folder.get_range("points/large 1.copc.laz", range).await.expect("readable");
    assert_eq!(got, &large[8_388_600..8_388_700]);
    assert!(folder.get_range("points/large 1.copc.laz", 17_000_000..17_000_009).await.is_err());
    let listed = folder.list().await.expect("readable");
    let wanted = [
        ("a b/ü%20.jpg".to_owned(), 4),
        ("empty.tif".to_owned(), 0),
        ("points/large 1.copc.laz".to_owned(), 17_000_003),
    ];
    assert_eq!(listed, wanted);
}

async fn republish(catalog: &Catalog, folder: &SceneFolder, old: &Scene) {
    let mut anew = manifest("x");
    anew.fingerprint = "second".into();
    folder.put_manifest(&anew).await.expect("writable");
    let within_a_second = catalog.scene(folder.name()).await.expect("published");
    assert!(within_a_second.manifest.fingerprint.len() <= 6);
    tokio::time::sleep(catalog::TRUSTED).await;
    let scene = catalog.scene(folder.name()).await.expect("published");
    assert_eq!(scene.manifest.fingerprint, "second");
    assert_eq!(old.manifest.fingerprint, "", "who holds the old version keeps it");
    tokio::time::sleep(catalog::TRUSTED).await;
    let same = catalog.scene(folder.name()).await.expect("published");
    assert!(Arc::ptr_eq(&same, &scene), "the same bytes are the same scene");
}

#[tokio::test]
async fn paths_and_names_stay_below_their_store() {
    let store = Store::open_with("memory:///", []).expect("memory");
    for name in ["", ".", "..", ".hidden", "a/b", "a\\b", "a\nb"] {
        let error = store.scene_folder(name).expect_err(name);
        assert!(matches!(error, StoreError::BadSceneName { .. }), "{error}");
    }
    let folder = store.scene_folder("street").expect("valid");
    for path in [
        "",
        "/",
        "/etc/passwd",
        "../other/scene.json",
        "a/../../b",
        "a//b",
        "a/",
        "./a",
        "a\\..\\b",
        "a\0",
    ] {
        let error = folder.path(path).expect_err(path);
        assert!(matches!(error, StoreError::BadPath { .. }), "{error}");
    }
}

#[tokio::test]
async fn the_same_scene_in_two_stores_names_both() {
    let stores =
        ["memory:///one", "memory:///two"].map(|url| Store::open_with(url, []).expect(url));
    for store in &stores {
        let folder = store.scene_folder("street").expect("valid");
        folder.put_manifest(&manifest("street")).await.expect("writable");
    }
    let error = Catalog::open(stores.clone()).await.expect_err("twice").to_string();
    for part in ["street", "memory:///one", "memory:///two"] {
        assert!(error.contains(part), "{error}");
    }
    let direct = Store { prefix: "two/street".into(), ..stores[1].clone() };
    let catalog = Catalog::open([direct]).await.expect("one scene of a store");
    assert_eq!(catalog.names().await.expect("readable"), ["street"]);
    assert!(catalog.scene("other").await.is_err());
}

#[tokio::test]
async fn a_damaged_manifest_hides_no_other_scene() {
    let store = Store::open_with("memory:///", []).expect("memory");
    for (name, text) in [("a", "{\"format\": 99}"), ("b", "no json"), ("c", "{\"format\": 3}")] {
        let path = store.scene_folder(name).expect("valid").path(Manifest::PATH).expect("valid");
        let text = text.to_owned().into_bytes();
        object_store::ObjectStoreExt::put(&store.store, &path, text.into()).await.expect("memory");
    }
    let folder = store.scene_folder("good").expect("valid");
    folder.put_manifest(&manifest("good")).await.expect("writable");
    let catalog = Catalog::open([store]).await.expect("readable");
    let scenes = catalog.scenes().await.expect("readable");
    assert_eq!(scenes.iter().map(|s| s.folder.name()).collect::<Vec<_>>(), ["good"]);
    for (name, says) in [("a", "format 99"), ("b", "expected"), ("c", "missing field")] {
        let error = catalog.scene(name).await.expect_err(name).to_string();
        assert!(error.contains(name) && error.contains(says), "{error}");
    }
}

#[tokio::test]
async fn what_cannot_be_read_again_is_not_published() {
    let store = Store::open_with("memory:///", []).expect("memory");
    let folder = store.scene_folder("street").expect("valid");
    let mut unplaced = manifest("street");
    unplaced.scene.origin.x = f64::NAN;
    let error = folder.put_manifest(&unplaced).await.expect_err("null is no number");
    assert!(matches!(error, StoreError::BadManifest { .. }), "{error}");
    assert!(store.scenes().await.expect("readable").is_empty());
}

#[cfg(unix)]
#[tokio::test]
async fn a_store_that_is_not_writable_says_what_to_do() {
    // A file where a folder is needed stops even an administrator, whom permissions do not.
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("street"), b"in the way").expect("writable");
    let store = Store::open_with(folder.path().to_str().expect("text"), []).expect("a folder");
    let scene = store.scene_folder("street").expect("valid");
    let error = scene.put_manifest(&manifest("street")).await.expect_err("no folder").to_string();
    assert!(error.contains("in the way"), "{error}");
    assert_eq!(std::fs::read(folder.path().join("street")).expect("there"), b"in the way");
}

#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_full_disk_says_what_to_do() {
    // /dev/full is a disk that is always full: every write to it fails with ENOSPC.
    let full = std::fs::write("/dev/full", b"x").expect_err("always full");
    let error = StoreError::from(object_store::Error::Generic { store: "x", source: full.into() });
    assert!(error.to_string().contains("free some space"), "{error}");
}

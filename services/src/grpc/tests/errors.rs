//! Bad requests get the standard code and the name of what is wrong.

use flaneur_proto::{MAX_KEYS, v1};
use flaneur_scene::{ImageId, NodeKey, Region};
use tonic::{Code, Status};
use tonic_types::StatusExt;

use super::answers::channel;
use super::street::{self, SCENE};
use super::watched::Watched;
use crate::grpc::in_process;
use crate::store::Catalog;

use v1::footprint_service_client::FootprintServiceClient;
use v1::ground_service_client::GroundServiceClient;
use v1::panorama_service_client::PanoramaServiceClient;
use v1::point_service_client::PointServiceClient;
use v1::scene_service_client::SceneServiceClient;

/// Asserts an INVALID_ARGUMENT that names `field`, in words and in the details.
#[track_caller]
fn assert_invalid(status: &Status, field: &str) {
    assert_eq!(status.code(), Code::InvalidArgument, "{status}");
    assert!(status.message().starts_with(&format!("{field}: ")), "{status}");
    let details = status.get_details_bad_request().expect("details");
    assert_eq!(details.field_violations[0].field, field);
    assert!(status.get_details_retry_info().is_none(), "it would be refused again: {status}");
}

/// Asserts a NOT_FOUND whose message holds all of `names`.
#[track_caller]
fn assert_missing(status: &Status, names: &[&str]) {
    assert_eq!(status.code(), Code::NotFound, "{status}");
    for name in names {
        assert!(status.message().contains(name), "{name}: {status}");
    }
    assert!(status.get_details_resource_info().is_some(), "{status}");
    assert!(status.get_details_retry_info().is_none(), "it would be missing again: {status}");
}

#[tokio::test]
async fn scenes_that_do_not_exist_are_named() {
    let channel = channel().await;
    let mut scenes = SceneServiceClient::new(channel.clone());
    let mut get = async |scene: &str| {
        let request = v1::GetSceneRequest { scene: scene.into() };
        scenes.get_scene(request).await.expect_err(scene)
    };
    assert_missing(&get("nowhere").await, &["\"nowhere\""]);
    for bad in ["", "..", "../x", "a/b", ".x", "a\0"] {
        assert_invalid(&get(bad).await, "scene");
    }
    let mut points = PointServiceClient::new(channel);
    let request = v1::StreamChunksRequest { scene: "nowhere".into(), ..Default::default() };
    assert_missing(&points.stream_chunks(request).await.expect_err("no scene"), &["nowhere"]);
}

#[tokio::test]
async fn regions_that_make_no_sense_name_their_field() {
    let channel = channel().await;
    let good = v1::BoundingBox { min_x: 0.0, min_y: 0.0, max_x: 1.0, max_y: 1.0 };
    let nan = v1::BoundingBox { min_x: f64::NAN, ..good };
    let turned = v1::BoundingBox { min_y: 2.0, ..good };
    let endless = v1::BoundingBox { max_x: f64::INFINITY, ..good };
    let centre = v1::Point2 { x: 0.0, y: 0.0 };
    let lost = v1::Point2 { x: f64::NAN, y: 0.0 };
    let cases = [
        (Some(nan), None, 0.0, "bbox.min_x"),
        (Some(turned), None, 0.0, "bbox.min_y"),
        (Some(endless), None, 0.0, "bbox.max_x"),
        (Some(good), Some(centre), 1.0, "centre"),
        (None, Some(lost), 1.0, "centre.x"),
        (None, Some(centre), -1.0, "radius_m"),
        (None, Some(centre), f64::NAN, "radius_m"),
        (None, None, 5.0, "centre"),
    ];
    let mut footprints = FootprintServiceClient::new(channel.clone());
    let mut ground = GroundServiceClient::new(channel.clone());
    let mut panoramas = PanoramaServiceClient::new(channel);
    for (bbox, centre, radius_m, field) in cases {
        let scene = SCENE.to_owned();
        let request =
            v1::StreamFootprintsRequest { scene, bbox, centre, radius_m, geometry_only: false };
        assert_invalid(&footprints.stream_footprints(request).await.expect_err(field), field);
        let scene = SCENE.to_owned();
        let request = v1::StreamGroundRequest { scene, bbox, centre, radius_m, step: 0 };
        assert_invalid(&ground.stream_ground(request).await.expect_err(field), field);
        let scene = SCENE.to_owned();
        let request = v1::StreamPanoramasRequest { scene, bbox, centre, radius_m };
        assert_invalid(&panoramas.stream_panoramas(request).await.expect_err(field), field);
    }
    let request =
        v1::StreamGroundRequest { step: 3, ..v1::StreamGroundRequest::new(SCENE, Region::All) };
    assert_invalid(&ground.stream_ground(request).await.expect_err("step"), "step");
}

#[tokio::test]
async fn images_that_do_not_exist_are_named() {
    let mut client = PanoramaServiceClient::new(channel().await);
    let colour = |panorama: &str, camera: &str, level| v1::ImageKey {
        panorama: panorama.into(),
        camera: camera.into(),
        level,
        layer: v1::ImageLayer::Colour.into(),
    };
    let good = colour("p1", "front", 0);
    let mut ask = async |bad: v1::ImageKey| {
        let images = vec![good.clone(), bad];
        let request = v1::StreamImagesRequest { scene: SCENE.into(), images };
        client.stream_images(request).await.expect_err("nothing is sent before all is found")
    };
    assert_missing(&ask(colour("p99", "front", 0)).await, &["panorama", "p99"]);
    assert_missing(&ask(colour("p1", "rear", 0)).await, &["camera", "rear", "p1"]);
    assert_missing(&ask(colour("p1", "front", 2)).await, &["level 2", "p1/front"]);
    assert_missing(&ask(colour("p1", "front", u32::MAX)).await, &["level", "p1/front"]);
    let id = ImageId::new("p1", "front").expect("valid");
    assert_missing(&ask(v1::ImageKey::mask(&id)).await, &["mask", "p1/front"]);
    let deep = v1::ImageKey {
        level: 1,
        ..v1::ImageKey::mask(&ImageId::new("p2", "front").expect("valid"))
    };
    assert_missing(&ask(deep).await, &["mask", "p2/front"]);
    assert_invalid(&ask(colour("..", "front", 0)).await, "images[1].panorama");
    assert_invalid(&ask(colour("p1", "a/b", 0)).await, "images[1].camera");
    let unknown = v1::ImageKey { layer: 77, ..good.clone() };
    assert_invalid(&ask(unknown).await, "images[1].layer");
    let images = vec![good.clone(); MAX_KEYS + 1];
    let request = v1::StreamImagesRequest { scene: SCENE.into(), images };
    assert_invalid(&client.stream_images(request).await.expect_err("too many"), "images");
}

#[tokio::test]
async fn nodes_that_do_not_exist_are_named() {
    let mut client = PointServiceClient::new(channel().await);
    let key = |level, x, y, z| v1::NodeKey { level, x, y, z };
    let root = v1::NodeKey::from(NodeKey::ROOT);
    let mut ask = async |source: &str, bad| {
        let nodes = vec![root, bad];
        let request = v1::StreamChunksRequest { scene: SCENE.into(), source: source.into(), nodes };
        client.stream_chunks(request).await.expect_err("nothing is sent before all is found")
    };
    assert_missing(&ask("air", key(5, 0, 0, 0)).await, &["node 5-0-0-0", "\"air\"", SCENE]);
    assert_missing(&ask("air", key(30, 0, 0, 0)).await, &["node 30-0-0-0"]);
    assert_missing(&ask("sea", root).await, &["point source", "\"sea\""]);
    assert_invalid(&ask("", root).await, "source");
    assert_invalid(&ask("air", key(0, 1, 0, 0)).await, "nodes[1].x");
    assert_invalid(&ask("air", key(31, 0, 0, 0)).await, "nodes[1].level");
    let nodes = vec![root; MAX_KEYS + 1];
    let request = v1::StreamChunksRequest { scene: SCENE.into(), source: "air".into(), nodes };
    assert_invalid(&client.stream_chunks(request).await.expect_err("too many"), "nodes");

    let page = Some(key(3, 0, 0, 0));
    let request = v1::GetHierarchyRequest { scene: SCENE.into(), source: "air".into(), page };
    let status = client.get_hierarchy(request).await.expect_err("a node, but no page");
    assert_missing(&status, &["page 3-0-0-0"]);
    let page = Some(key(2, 4, 0, 0));
    let request = v1::GetHierarchyRequest { scene: SCENE.into(), source: "air".into(), page };
    assert_invalid(&client.get_hierarchy(request).await.expect_err("out of range"), "page.x");
}

#[tokio::test]
async fn a_store_that_fails_is_worth_another_try() {
    let (objects, reads) = Watched::over(street::street().await);
    let catalog = Catalog::open([street::store(objects)]).await.expect("memory");
    let channel = in_process(catalog).await.expect("services");
    reads.break_down();
    let request = v1::StreamFootprintsRequest { scene: SCENE.into(), ..Default::default() };
    let footprints = FootprintServiceClient::new(channel.clone()).stream_footprints(request).await;
    let request = v1::GetStationsRequest { scene: SCENE.into(), source: "drive".into() };
    let stations = PointServiceClient::new(channel).get_stations(request).await;
    for status in [footprints.expect_err("broken"), stations.expect_err("broken")] {
        assert_eq!(status.code(), Code::Unavailable, "{status}");
        let hint = status.get_details_retry_info().and_then(|hint| hint.retry_delay);
        assert!(hint.is_some_and(|delay| !delay.is_zero()), "{status}");
    }
}

#[tokio::test]
async fn a_damaged_store_is_reported_without_its_paths() {
    let objects = street::street().await;
    let damaged = street::store(objects.clone());
    let folder = damaged.scene_folder(SCENE).expect("valid");
    let manifest = folder.manifest().await.expect("memory").expect("published");
    let table = manifest.panoramas.expect("there").file.path;
    let path = folder.path(&table).expect("valid");
    let zeros = vec![0u8; 4096];
    object_store::ObjectStoreExt::put(&*objects, &path, zeros.into()).await.expect("memory");
    folder.delete(&manifest.footprints.expect("there").file.path).await.expect("memory");
    let catalog = Catalog::open([damaged]).await.expect("memory");
    let channel = in_process(catalog).await.expect("services");
    let request = v1::StreamPanoramasRequest { scene: SCENE.into(), ..Default::default() };
    let status = PanoramaServiceClient::new(channel.clone()).stream_panoramas(request).await;
    let request = v1::StreamFootprintsRequest { scene: SCENE.into(), ..Default::default() };
    let gone = FootprintServiceClient::new(channel).stream_footprints(request).await;
    for status in [status.expect_err("damaged"), gone.expect_err("gone")] {
        assert_eq!(status.code(), Code::DataLoss, "{status}");
        assert!(!status.message().contains(".fgb"), "{status}");
        assert!(status.get_details_retry_info().is_none(), "it stays damaged: {status}");
    }
}

//! What was published comes back through the services, number for number.

use std::collections::{BTreeMap, BTreeSet};

use flaneur_proto::{Assembly, v1};
use flaneur_scene::{
    Bounds2, Footprint, GroundTile, ImageId, Node, NodeKey, Panorama, Region, SceneInfo,
};
use futures::TryStreamExt;
use glam::DVec2;
use tonic::Streaming;
use tonic::transport::Channel;

use super::street::{self, NODE_POINTS, SCENE};
use crate::grpc::in_process;
use crate::layers::copc::deep_tree;
use crate::store::Catalog;

use v1::footprint_service_client::FootprintServiceClient;
use v1::ground_service_client::GroundServiceClient;
use v1::panorama_service_client::PanoramaServiceClient;
use v1::point_service_client::PointServiceClient;
use v1::scene_service_client::SceneServiceClient;

/// A channel to the services over the street.
pub(super) async fn channel() -> Channel {
    let catalog = Catalog::open([street::store(street::street().await)]).await.expect("memory");
    in_process(catalog).await.expect("services")
}

pub(super) async fn all<M>(stream: Streaming<M>) -> Vec<M> {
    stream.try_collect().await.expect("a stream that ends well")
}

/// The region's shape does not matter to what a request may ask for.
fn regions() -> [Region; 3] {
    let bounds = Bounds2 { min: DVec2::new(31.0, 4.0), max: DVec2::new(52.0, 6.0) };
    [
        Region::All,
        Region::Box(bounds),
        Region::Disc { centre: DVec2::new(100.5, 0.0), radius_m: 21.0 },
    ]
}

#[tokio::test]
async fn scenes_are_listed_and_described() {
    let mut client = SceneServiceClient::new(channel().await);
    let listed = client.list_scenes(v1::ListScenesRequest {}).await.expect("listed").into_inner();
    let request = v1::GetSceneRequest { scene: SCENE.into() };
    let scene = client.get_scene(request).await.expect("there").into_inner().scene;
    assert_eq!(listed.scenes, [scene.clone().expect("described")]);
    let info = SceneInfo::try_from(scene.expect("described")).expect("valid");
    assert_eq!((info.name.as_str(), info.footprints, info.images), (SCENE, 20, 80));
    assert_eq!(info.point_sources.len(), 2);
}

#[tokio::test]
async fn footprints_of_every_region_come_back() {
    let mut client = FootprintServiceClient::new(channel().await);
    for region in regions() {
        let request = v1::StreamFootprintsRequest::new(SCENE, region);
        let batches =
            all(client.stream_footprints(request).await.expect("there").into_inner()).await;
        let mut got: Vec<Footprint> = batches
            .into_iter()
            .flat_map(|batch| batch.footprints)
            .map(|footprint| Footprint::try_from(footprint).expect("valid"))
            .collect();
        let mut wanted = street::footprints();
        wanted.retain(|footprint| region.meets(&footprint.bounds()));
        assert!(!wanted.is_empty(), "{region:?}");
        got.sort_by(|a, b| a.id.cmp(&b.id));
        wanted.sort_by(|a, b| a.id.cmp(&b.id));
        assert_eq!(got, wanted, "{region:?}");

        let request = v1::StreamFootprintsRequest {
            geometry_only: true,
            ..v1::StreamFootprintsRequest::new(SCENE, region)
        };
        let batches =
            all(client.stream_footprints(request).await.expect("there").into_inner()).await;
        let bare: usize = batches.iter().map(|batch| batch.footprints.len()).sum();
        assert_eq!(bare, wanted.len(), "{region:?}");
        for message in batches.into_iter().flat_map(|batch| batch.footprints) {
            let footprint = Footprint::try_from(message).expect("valid");
            let whole = wanted.iter().find(|whole| whole.id == footprint.id).expect("known");
            assert_eq!(footprint, Footprint { attributes: String::new(), ..whole.clone() });
        }
    }
}

#[tokio::test]
async fn ground_tiles_of_every_region_come_back() {
    let mut client = GroundServiceClient::new(channel().await);
    let mut tiles = Vec::new();
    for region in regions() {
        let request = v1::StreamGroundRequest::new(SCENE, region);
        let got = all(client.stream_ground(request).await.expect("there").into_inner()).await;
        let got: Vec<GroundTile> =
            got.into_iter().map(|tile| GroundTile::try_from(tile).expect("valid")).collect();
        assert!(got.iter().all(|tile| region.meets(&tile.bounds())), "{region:?}");
        tiles.push(got.len());
    }
    // 200 × 70 nodes in tiles of 64 cells: four by two, fewer for a part.
    assert_eq!(tiles[0], 8);
    assert!(tiles[1..].iter().all(|count| (1..8).contains(count)), "{tiles:?}");
}

#[tokio::test]
async fn coarse_ground_has_the_heights_of_every_stepth_node() {
    let mut client = GroundServiceClient::new(channel().await);
    let mut ask = async |step| {
        let request =
            v1::StreamGroundRequest { step, ..v1::StreamGroundRequest::new(SCENE, Region::All) };
        let tiles = all(client.stream_ground(request).await.expect("there").into_inner()).await;
        let tile = |tile| GroundTile::try_from(tile).expect("valid");
        tiles.into_iter().map(tile).map(|tile| (tile.index, tile)).collect::<BTreeMap<_, _>>()
    };
    let (fine, coarse) = (ask(0).await, ask(8).await);
    assert!(fine.keys().eq(coarse.keys()) && fine.len() == 8);
    for (index, coarse) in coarse {
        let fine = &fine[&index];
        assert_eq!((coarse.origin, coarse.spacing_m), (fine.origin, 8.0));
        let (columns, rows) = (fine.columns as usize, fine.rows() as usize);
        assert_eq!(coarse.columns as usize, (columns - 1).div_ceil(8) + 1);
        for (node, height) in coarse.heights.iter().enumerate() {
            let (row, column) = (node / coarse.columns as usize, node % coarse.columns as usize);
            let at = (8 * row).min(rows - 1) * columns + (8 * column).min(columns - 1);
            assert_eq!(*height, fine.heights[at], "{index:?}, node {node}");
        }
    }
}

#[tokio::test]
async fn panoramas_come_back_nearest_to_the_centre_first() {
    let mut client = PanoramaServiceClient::new(channel().await);
    for region in [Region::All, regions()[2]] {
        let request = v1::StreamPanoramasRequest::new(SCENE, region);
        let got = all(client.stream_panoramas(request).await.expect("there").into_inner()).await;
        let got: Vec<Panorama> =
            got.into_iter().map(|panorama| Panorama::try_from(panorama).expect("valid")).collect();
        let mut wanted = street::rigs();
        wanted.retain(|rig| {
            let at = rig.position.truncate();
            region.meets(&Bounds2 { min: at, max: at })
        });
        if let Region::Disc { centre, .. } = region {
            let distance = |p: &Panorama| p.position.truncate().distance(centre);
            wanted.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
            assert_eq!(got, wanted);
        } else {
            let by_id = |panoramas: Vec<Panorama>| -> BTreeMap<String, Panorama> {
                panoramas.into_iter().map(|p| (p.id.clone(), p)).collect()
            };
            assert_eq!(by_id(got), by_id(wanted));
        }
    }
}

#[tokio::test]
async fn images_come_in_the_asked_order_whole_and_in_parts() {
    let mut client = PanoramaServiceClient::new(channel().await);
    let id = |panorama, camera| ImageId::new(panorama, camera).expect("valid");
    let images = vec![
        v1::ImageKey::colour(&id("p7", "left"), 1),
        v1::ImageKey::colour(&id("p2", "front"), 0),
        v1::ImageKey::mask(&id("p2", "left")),
        v1::ImageKey::colour(&id("p7", "left"), 1),
    ];
    let request = v1::StreamImagesRequest { scene: SCENE.into(), images: images.clone() };
    let parts = all(client.stream_images(request).await.expect("there").into_inner()).await;
    assert!(parts.len() > images.len(), "the large one comes in parts");
    let mut whole = Vec::new();
    let mut assembly: Option<Assembly> = None;
    for part in parts {
        let open = match assembly.as_mut() {
            Some(open) => open,
            None => assembly.insert(Assembly::new(part.total_bytes, 1 << 30).expect("small")),
        };
        if let Some(bytes) = open.push(part.total_bytes, part.offset, &part.data).expect("in order")
        {
            whole.push((part.image.expect("named"), part.media_type, bytes));
            assembly = None;
        }
    }
    let keys: Vec<_> = whole.iter().map(|(key, ..)| key.clone()).collect();
    assert_eq!(keys, images);
    let kinds: Vec<_> = whole.iter().map(|(_, kind, _)| kind.as_str()).collect();
    assert_eq!(kinds, ["image/jpeg", "image/jpeg", "image/png", "image/jpeg"]);
    assert_eq!(whole[0].2, street::image("p7", "left", 1));
    assert_eq!(whole[1].2, street::image("p2", "front", 0));
    assert_eq!(whole[2].2, street::mask());

    // All of it was known before.
    let request = v1::StreamPanoramasRequest::new(SCENE, Region::All);
    let rigs = all(client.stream_panoramas(request).await.expect("there").into_inner()).await;
    for (key, _, bytes) in whole {
        let rig = rigs.iter().find(|rig| rig.id == key.panorama).expect("listed");
        let camera = rig.cameras.iter().find(|camera| camera.id == key.camera).expect("listed");
        let announced = match key.layer() {
            v1::ImageLayer::Colour => camera.levels[key.level as usize],
            v1::ImageLayer::Mask => camera.mask.as_ref().expect("masked").image.expect("stated"),
        };
        let (byte_size, crc32) = (bytes.len() as u64, crc32fast::hash(&bytes));
        assert_eq!(announced, v1::StoredImage { byte_size, crc32 });
    }
}

#[tokio::test]
async fn hierarchies_come_page_by_page_and_lead_to_every_chunk() {
    let mut client = PointServiceClient::new(channel().await);
    let ask = |page| v1::GetHierarchyRequest { scene: SCENE.into(), source: "air".into(), page };
    let pages = all(client.get_hierarchy(ask(None)).await.expect("there").into_inner()).await;
    assert_eq!(pages[0].page, Some(NodeKey::ROOT.into()));
    let mut nodes = Vec::new();
    let mut leads: BTreeSet<NodeKey> = BTreeSet::from([NodeKey::ROOT]);
    for page in &pages {
        let root = NodeKey::try_from(page.page.expect("named")).expect("valid");
        assert!(leads.contains(&root), "pages come after the page that leads to them");
        for entry in &page.entries {
            if entry.is_page {
                leads.insert(NodeKey::try_from(entry.key.expect("named")).expect("valid"));
            } else {
                nodes.push(Node::try_from(*entry).expect("valid"));
            }
        }
    }
    let found: BTreeSet<NodeKey> = nodes.iter().map(|node| node.key).collect();
    assert_eq!(found, deep_tree().into_iter().collect());
    assert!(leads.len() > 1, "more than one page");
    for root in leads {
        let page =
            all(client.get_hierarchy(ask(Some(root.into()))).await.expect("there").into_inner())
                .await;
        assert_eq!(
            page,
            pages.iter().filter(|p| p.page == Some(root.into())).cloned().collect::<Vec<_>>()
        );
    }

    let keys: Vec<v1::NodeKey> = nodes.iter().rev().map(|node| node.key.into()).collect();
    let request =
        v1::StreamChunksRequest { scene: SCENE.into(), source: "air".into(), nodes: keys.clone() };
    let chunks = all(client.stream_chunks(request).await.expect("there").into_inner()).await;
    assert_eq!(chunks.iter().filter_map(|chunk| chunk.key).collect::<Vec<_>>(), keys);
    for (chunk, node) in chunks.iter().zip(nodes.iter().rev()) {
        assert_eq!(chunk.point_count, NODE_POINTS);
        assert_eq!((chunk.offset, chunk.total_bytes), (0, u64::from(node.byte_size)));
        assert_eq!(chunk.data.len() as u64, chunk.total_bytes);
        assert_eq!(crc32fast::hash(&chunk.data), node.crc32);
    }
}

#[tokio::test]
async fn stations_come_back_where_there_are_any() {
    let mut client = PointServiceClient::new(channel().await);
    for (source, wanted) in [("drive", street::stations()), ("air", vec![])] {
        let request = v1::GetStationsRequest { scene: SCENE.into(), source: source.into() };
        let answer = client.get_stations(request).await.expect("there").into_inner();
        assert_eq!(Vec::try_from(answer.stations.expect("stated")), Ok(wanted), "{source}");
    }
}

#[tokio::test]
async fn nothing_asked_is_nothing_answered() {
    let channel = channel().await;
    let far = Region::Disc { centre: DVec2::splat(1e7), radius_m: 1.0 };
    let mut client = FootprintServiceClient::new(channel.clone());
    let request = v1::StreamFootprintsRequest::new(SCENE, far);
    assert!(
        all(client.stream_footprints(request).await.expect("there").into_inner()).await.is_empty()
    );
    let mut client = PointServiceClient::new(channel.clone());
    let request =
        v1::StreamChunksRequest { scene: SCENE.into(), source: "air".into(), nodes: vec![] };
    assert!(all(client.stream_chunks(request).await.expect("there").into_inner()).await.is_empty());
    let mut client = PanoramaServiceClient::new(channel);
    let request = v1::StreamImagesRequest { scene: SCENE.into(), images: vec![] };
    assert!(all(client.stream_images(request).await.expect("there").into_inner()).await.is_empty());
}

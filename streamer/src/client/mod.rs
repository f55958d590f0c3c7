//! The calls of the data services, with everything that comes back checked.

mod incoming;
mod payload;

use std::future::Future;
use std::sync::Arc;

use flaneur_proto::v1::footprint_service_client::FootprintServiceClient;
use flaneur_proto::v1::ground_service_client::GroundServiceClient;
use flaneur_proto::v1::panorama_service_client::PanoramaServiceClient;
use flaneur_proto::v1::point_service_client::PointServiceClient;
use flaneur_proto::v1::scene_service_client::SceneServiceClient;
use flaneur_proto::{FieldError, v1};
use flaneur_scene::{Footprint, GroundTile, Node, NodeKey, Panorama, Region, SceneInfo, Station};
use futures::Stream;
use prost::Message;
use tokio::sync::Semaphore;
use tonic::transport::Channel;
use tonic::{Response, Status};

pub(crate) use payload::{Payload, Payloads};

use crate::StreamError;
use crate::traffic::Traffic;
use incoming::{Incoming, STALL};

/// Calls under way at once; further ones wait their turn.
const MAX_CALLS: usize = 8;
/// Vertices of footprints that one region may hold.
const MAX_FOOTPRINT_VERTICES: usize = 20_000_000;
/// Heights of terrain that one region may hold.
const MAX_GROUND_HEIGHTS: usize = 50_000_000;
/// Entries of one page of a point hierarchy.
const MAX_PAGE_ENTRIES: usize = 4_000_000;

/// A client of one scene's data services. Clones share connection, limits and counts.
#[derive(Clone, Debug)]
pub struct Client {
    channel: Channel,
    scene: String,
    calls: Arc<Semaphore>,
    traffic: Arc<Traffic>,
}

/// One entry of a point hierarchy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HierarchyEntry {
    /// A node, perhaps without points of its own.
    Node(Node),
    /// The root of a page that is not loaded.
    Page(NodeKey),
}

impl Client {
    /// Every scene that the service behind `channel` has, by name.
    pub async fn list_scenes(channel: Channel) -> Result<Vec<SceneInfo>, StreamError> {
        let call = "ListScenes";
        let mut client = SceneServiceClient::new(channel);
        let response = in_time(call, client.list_scenes(v1::ListScenesRequest {})).await?;
        let scenes = response.into_inner().scenes.into_iter();
        scenes.map(|s| SceneInfo::try_from(s).map_err(StreamError::field(call))).collect()
    }

    /// A client of `scene`; nothing is sent yet.
    pub fn new(channel: Channel, scene: impl Into<String>) -> Self {
        Self {
            channel,
            scene: scene.into(),
            calls: Arc::new(Semaphore::new(MAX_CALLS)),
            traffic: Arc::default(),
        }
    }

    /// Bytes of all messages received so far, without transport framing.
    pub fn bytes_received(&self) -> u64 {
        self.traffic.bytes()
    }

    /// Requests sent so far.
    pub fn requests(&self) -> u64 {
        self.traffic.requests()
    }

    /// What the scene holds.
    pub async fn scene(&self) -> Result<SceneInfo, StreamError> {
        let call = "GetScene";
        self.traffic.request();
        let request = v1::GetSceneRequest { scene: self.scene.clone() };
        let mut client = SceneServiceClient::new(self.channel.clone());
        let message = in_time(call, client.get_scene(request)).await?.into_inner();
        self.traffic.received(message.encoded_len());
        let absent = || FieldError::new("scene", "is absent");
        let scene = message.scene.ok_or_else(absent).and_then(SceneInfo::try_from);
        scene.map_err(StreamError::field(call))
    }

    /// The footprints that meet `region`, in the order of the service.
    pub async fn footprints(&self, region: Region) -> Result<Vec<Footprint>, StreamError> {
        let call = "StreamFootprints";
        let request = v1::StreamFootprintsRequest::new(&self.scene, region);
        let mut client = FootprintServiceClient::new(self.channel.clone());
        let mut batches = self.open(call, client.stream_footprints(request)).await?;
        let (mut footprints, mut vertices) = (Vec::new(), 0);
        while let Some(batch) = batches.next().await? {
            for message in batch.footprints {
                let footprint = Footprint::try_from(message).map_err(StreamError::field(call))?;
                // A footprint counts for itself, too, so that empty ones are bounded.
                vertices += 1 + footprint
                    .polygons
                    .iter()
                    .flat_map(|polygon| &polygon.rings)
                    .map(Vec::len)
                    .sum::<usize>();
                bounded(call, "vertices", vertices, MAX_FOOTPRINT_VERTICES)?;
                footprints.push(footprint);
            }
        }
        Ok(footprints)
    }

    /// The terrain tiles that meet `region`, in the order of the service.
    pub async fn ground(&self, region: Region) -> Result<Vec<GroundTile>, StreamError> {
        let call = "StreamGround";
        let request = v1::StreamGroundRequest::new(&self.scene, region);
        let mut client = GroundServiceClient::new(self.channel.clone());
        let mut messages = self.open(call, client.stream_ground(request)).await?;
        let (mut tiles, mut heights) = (Vec::new(), 0);
        while let Some(message) = messages.next().await? {
            let tile = GroundTile::try_from(message).map_err(StreamError::field(call))?;
            heights += 1 + tile.heights.len();
            bounded(call, "heights", heights, MAX_GROUND_HEIGHTS)?;
            tiles.push(tile);
        }
        Ok(tiles)
    }

    /// The panoramas in `region` as they arrive: nearest first where it is a disc. Dropping
    /// the stream ends the call.
    pub async fn panoramas(
        &self,
        region: Region,
    ) -> Result<impl Stream<Item = Result<Panorama, StreamError>> + Send + use<>, StreamError> {
        let call = "StreamPanoramas";
        let request = v1::StreamPanoramasRequest::new(&self.scene, region);
        let mut client = PanoramaServiceClient::new(self.channel.clone());
        let messages = self.open(call, client.stream_panoramas(request)).await?;
        Ok(futures::stream::try_unfold(messages, move |mut messages| async move {
            let Some(message) = messages.next().await? else { return Ok(None) };
            let panorama = Panorama::try_from(message).map_err(StreamError::field(call))?;
            Ok(Some((panorama, messages)))
        }))
    }

    /// The stored files of `keys`, in that order, each at most `limit` bytes.
    pub(crate) async fn images(
        &self,
        keys: Vec<v1::ImageKey>,
        limit: u64,
    ) -> Result<Payloads<v1::ImagePart>, StreamError> {
        let call = "StreamImages";
        let request = v1::StreamImagesRequest { scene: self.scene.clone(), images: keys.clone() };
        let mut client = PanoramaServiceClient::new(self.channel.clone());
        let parts = self.open(call, client.stream_images(request)).await?;
        Ok(Payloads::new(parts, keys, limit))
    }

    /// The chunks of `nodes` of a point source, in that order, each at most `limit` bytes.
    pub(crate) async fn chunks(
        &self,
        source: &str,
        nodes: Vec<NodeKey>,
        limit: u64,
    ) -> Result<Payloads<v1::PointChunk>, StreamError> {
        let call = "StreamChunks";
        let nodes: Vec<v1::NodeKey> = nodes.into_iter().map(v1::NodeKey::from).collect();
        let request = v1::StreamChunksRequest {
            scene: self.scene.clone(),
            source: source.to_owned(),
            nodes: nodes.clone(),
        };
        let mut client = PointServiceClient::new(self.channel.clone());
        let parts = self.open(call, client.stream_chunks(request)).await?;
        Ok(Payloads::new(parts, nodes, limit))
    }

    /// Where a point source was taken from.
    pub(crate) async fn stations(&self, source: &str) -> Result<Vec<Station>, StreamError> {
        let call = "GetStations";
        self.traffic.request();
        let (scene, source) = (self.scene.clone(), source.to_owned());
        let mut client = PointServiceClient::new(self.channel.clone());
        let request = v1::GetStationsRequest { scene, source };
        let message = in_time(call, client.get_stations(request)).await?.into_inner();
        self.traffic.received(message.encoded_len());
        let stations = message.stations.unwrap_or_default();
        stations.try_into().map_err(|e: FieldError| StreamError::field(call)(e.within("stations")))
    }

    /// One page of a point source's hierarchy.
    pub(crate) async fn hierarchy_page(
        &self,
        source: &str,
        page: NodeKey,
    ) -> Result<Vec<HierarchyEntry>, StreamError> {
        let call = "GetHierarchy";
        let request = v1::GetHierarchyRequest {
            scene: self.scene.clone(),
            source: source.to_owned(),
            page: Some(page.into()),
        };
        let mut client = PointServiceClient::new(self.channel.clone());
        let mut pages = self.open(call, client.get_hierarchy(request)).await?;
        let mut entries = Vec::new();
        while let Some(message) = pages.next().await? {
            bounded(call, "entries", entries.len() + message.entries.len(), MAX_PAGE_ENTRIES)?;
            for entry in message.entries {
                entries.push(checked(entry).map_err(StreamError::field(call))?);
            }
        }
        Ok(entries)
    }

    /// Starts a streaming call once there is room for it.
    async fn open<M>(
        &self,
        call: &'static str,
        response: impl Future<Output = Result<Response<tonic::Streaming<M>>, Status>>,
    ) -> Result<Incoming<M>, StreamError> {
        let permit = Arc::clone(&self.calls).acquire_owned().await;
        let permit = permit.expect("the semaphore is never closed");
        self.traffic.request();
        let messages = in_time(call, response).await?.into_inner();
        Ok(Incoming::new(call, messages, Arc::clone(&self.traffic), permit))
    }
}

fn checked(entry: v1::HierarchyEntry) -> Result<HierarchyEntry, FieldError> {
    if !entry.is_page {
        return Ok(HierarchyEntry::Node(Node::try_from(entry)?));
    }
    let key = entry.key.ok_or_else(|| FieldError::new("key", "is absent"))?;
    Ok(HierarchyEntry::Page(NodeKey::try_from(key).map_err(|e| e.within("key"))?))
}

async fn in_time<T>(
    call: &'static str,
    response: impl Future<Output = Result<T, Status>>,
) -> Result<T, StreamError> {
    match tokio::time::timeout(STALL, response).await {
        Ok(response) => response.map_err(StreamError::status(call)),
        Err(_) => Err(StreamError::Stalled { call, seconds: STALL.as_secs() }),
    }
}

fn bounded(
    call: &'static str,
    what: &'static str,
    count: usize,
    limit: usize,
) -> Result<(), StreamError> {
    if count > limit { Err(StreamError::TooMuch { call, what, limit }) } else { Ok(()) }
}

//! The calls of the data services, with everything that comes back checked.

mod heard;
mod incoming;
mod payload;

use std::future::Future;
use std::sync::Arc;
use std::time::Duration;

use flaneur_proto::v1::footprint_service_client::FootprintServiceClient;
use flaneur_proto::v1::ground_service_client::GroundServiceClient;
use flaneur_proto::v1::panorama_service_client::PanoramaServiceClient;
use flaneur_proto::v1::point_service_client::PointServiceClient;
use flaneur_proto::v1::scene_service_client::SceneServiceClient;
use flaneur_proto::{FieldError, v1};
use flaneur_scene::{Footprint, GroundTile, Node, NodeKey, Panorama, Region, SceneInfo};
use futures::Stream;
use prost::Message;
use tokio::sync::Semaphore;
use tonic::{Response, Status};

pub(crate) use payload::{Part as Piece, Payloads};

use crate::StreamError;
use crate::servers::{Servers, Turn};
use crate::traffic::Traffic;
use heard::{Heard, Listened};
use incoming::Incoming;

/// Calls under way at once; further ones wait their turn.
const MAX_CALLS: usize = 32;
/// Vertices of footprints that one region may hold.
const MAX_FOOTPRINT_VERTICES: usize = 20_000_000;
/// Heights of terrain that one region may hold.
const MAX_GROUND_HEIGHTS: usize = 50_000_000;
/// Entries of one page of a point hierarchy.
const MAX_PAGE_ENTRIES: usize = 4_000_000;
/// Servers that fail and have said nothing for so long are out of reach: longer than they are let be.
const OUT_OF_REACH: Duration = Duration::from_secs(6);

/// A client of one scene's data services. Clones share connection, limits and counts.
#[derive(Clone, Debug)]
pub struct Client {
    servers: Servers,
    scene: String,
    calls: Arc<Semaphore>,
    traffic: Arc<Traffic>,
    heard: Heard,
}

/// One entry of a point hierarchy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HierarchyEntry {
    /// A node, perhaps without points of its own.
    Node(Node),
    /// The root of a page that is not loaded.
    Page(NodeKey),
}

impl Client {
    /// Every scene that the servers have, by name.
    pub async fn list_scenes(servers: impl Into<Servers>) -> Result<Vec<SceneInfo>, StreamError> {
        let this = Self::new(servers, "");
        let request = |channel| async move {
            SceneServiceClient::new(channel).list_scenes(v1::ListScenesRequest {}).await
        };
        let read = |answer: v1::ListScenesResponse| {
            answer.scenes.into_iter().map(SceneInfo::try_from).collect()
        };
        Ok(this.ask("ListScenes", request, read).await?.0)
    }

    /// A client of `scene`; nothing is sent yet.
    pub fn new(servers: impl Into<Servers>, scene: impl Into<String>) -> Self {
        Self {
            servers: servers.into(),
            scene: scene.into(),
            calls: Arc::new(Semaphore::new(MAX_CALLS)),
            traffic: Arc::default(),
            heard: Heard::default(),
        }
    }

    /// What was received and asked for so far.
    pub(crate) fn traffic(&self) -> &Traffic {
        &self.traffic
    }

    /// Whether no server can be reached: all have failed, and not a byte of any answer has come for six
    /// seconds. They are asked again all the same, for as long as something is wanted.
    pub fn is_cut_off(&self) -> bool {
        let failing = self.servers.failing_since();
        failing.is_some_and(|since| since.max(self.heard.last()).elapsed() >= OUT_OF_REACH)
    }

    /// Where it asks.
    pub(crate) fn servers(&self) -> &Servers {
        &self.servers
    }

    /// What the scene holds.
    pub async fn scene(&self) -> Result<SceneInfo, StreamError> {
        let name = self.scene.clone();
        let request = |channel| {
            let request = v1::GetSceneRequest { scene: name.clone() };
            async move { SceneServiceClient::new(channel).get_scene(request).await }
        };
        let read = |answer: v1::GetSceneResponse| {
            let absent = || FieldError::new("scene", "is absent");
            answer.scene.ok_or_else(absent).and_then(SceneInfo::try_from)
        };
        Ok(self.ask("GetScene", request, read).await?.0)
    }

    /// The footprints that meet `region`, without attributes, in the order of the service, and which that is.
    pub(crate) async fn footprints(
        &self,
        region: Region,
    ) -> Result<(Vec<v1::Footprint>, Turn), StreamError> {
        let call = "StreamFootprints";
        let request = v1::StreamFootprintsRequest {
            geometry_only: true,
            ..v1::StreamFootprintsRequest::new(&self.scene, region)
        };
        let mut batches = self
            .open(call, |channel| async move {
                FootprintServiceClient::new(channel).stream_footprints(request).await
            })
            .await?;
        let (mut footprints, mut vertices) = (Vec::new(), 0);
        while let Some(batch) = batches.next().await? {
            // So does a batch.
            vertices += 1;
            bounded(call, "vertices", vertices, MAX_FOOTPRINT_VERTICES)?;
            for footprint in batch.footprints {
                // A footprint counts for itself, too, so that empty ones are bounded.
                vertices += 1 + footprint
                    .polygons
                    .iter()
                    .flat_map(|polygon| &polygon.rings)
                    .map(|ring| 1 + ring.coordinates.len() / 2)
                    .sum::<usize>();
                bounded(call, "vertices", vertices, MAX_FOOTPRINT_VERTICES)?;
                footprints.push(footprint);
            }
        }
        Ok((footprints, batches.turn()))
    }

    /// The footprints that meet `region`, without their attributes.
    ///
    /// # Errors
    /// Where the service fails, or sends what are no footprints.
    pub async fn buildings(&self, region: Region) -> Result<Vec<Footprint>, StreamError> {
        let (footprints, turn) = self.footprints(region).await?;
        let footprints = footprints.into_iter().map(Footprint::try_from).collect();
        self.believed("StreamFootprints", turn, footprints)
    }

    /// The terrain tiles that meet `region`, of every `step`-th node, in the order of the service, and which
    /// that is.
    pub(crate) async fn ground(
        &self,
        region: Region,
        step: u32,
    ) -> Result<(Vec<v1::GroundTile>, Turn), StreamError> {
        let call = "StreamGround";
        let request =
            v1::StreamGroundRequest { step, ..v1::StreamGroundRequest::new(&self.scene, region) };
        let mut messages = self
            .open(call, |channel| async move {
                GroundServiceClient::new(channel).stream_ground(request).await
            })
            .await?;
        let (mut tiles, mut heights) = (Vec::new(), 0);
        while let Some(message) = messages.next().await? {
            heights += 1 + message.height_steps_mm.len();
            bounded(call, "heights", heights, MAX_GROUND_HEIGHTS)?;
            tiles.push(message);
        }
        Ok((tiles, messages.turn()))
    }

    /// The terrain in `region`, whole tiles of it with every node.
    ///
    /// # Errors
    /// Where the service fails, or sends what is no terrain.
    pub async fn terrain(&self, region: Region) -> Result<Vec<GroundTile>, StreamError> {
        let (tiles, turn) = self.ground(region, 1).await?;
        let tiles = tiles.into_iter().map(GroundTile::try_from).collect();
        self.believed("StreamGround", turn, tiles)
    }

    /// The panoramas in `region` as they arrive: nearest first where it is a disc. Dropping
    /// the stream ends the call.
    pub async fn panoramas(
        &self,
        region: Region,
    ) -> Result<impl Stream<Item = Result<Panorama, StreamError>> + Send + use<>, StreamError> {
        let call = "StreamPanoramas";
        let messages = self.open_panoramas(region).await?;
        Ok(futures::stream::try_unfold(messages, move |mut messages| async move {
            let Some(message) = messages.next().await? else { return Ok(None) };
            let panorama = Panorama::try_from(message).map_err(|error| {
                messages.distrust();
                StreamError::field(call)(error)
            })?;
            Ok(Some((panorama, messages)))
        }))
    }

    /// The same as they were sent.
    pub(crate) async fn open_panoramas(
        &self,
        region: Region,
    ) -> Result<Incoming<v1::Panorama>, StreamError> {
        let request = v1::StreamPanoramasRequest::new(&self.scene, region);
        self.open("StreamPanoramas", |channel| async move {
            PanoramaServiceClient::new(channel).stream_panoramas(request).await
        })
        .await
    }

    /// The stored files of `keys`, in that order, each at most `limit` bytes.
    pub(crate) async fn images(
        &self,
        keys: Vec<v1::ImageKey>,
        limit: u64,
    ) -> Result<Payloads<v1::ImagePart>, StreamError> {
        let call = "StreamImages";
        let request = v1::StreamImagesRequest { scene: self.scene.clone(), images: keys.clone() };
        let parts = self
            .open(call, |channel| async move {
                PanoramaServiceClient::new(channel).stream_images(request).await
            })
            .await?;
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
        let parts = self
            .open(call, |channel| async move {
                PointServiceClient::new(channel).stream_chunks(request).await
            })
            .await?;
        Ok(Payloads::new(parts, nodes, limit))
    }

    /// One page of a point source's hierarchy, in one message, and whose it is.
    pub(crate) async fn hierarchy_page(
        &self,
        source: &str,
        page: NodeKey,
    ) -> Result<(v1::HierarchyPage, Turn), StreamError> {
        let call = "GetHierarchy";
        let request = v1::GetHierarchyRequest {
            scene: self.scene.clone(),
            source: source.to_owned(),
            page: Some(page.into()),
        };
        let mut pages = self
            .open(call, |channel| async move {
                PointServiceClient::new(channel).get_hierarchy(request).await
            })
            .await?;
        let mut whole = v1::HierarchyPage { page: Some(page.into()), ..Default::default() };
        let mut messages = 0;
        while let Some(message) = pages.next().await? {
            messages += 1;
            // Empty messages count, too, so that they end.
            let entries = messages + whole.entries.len() + message.entries.len();
            bounded(call, "entries", entries, MAX_PAGE_ENTRIES)?;
            whole.entries.extend(message.entries);
        }
        Ok((whole, pages.turn()))
    }

    /// Where a point source was taken from, and who says so.
    pub(crate) async fn stations(&self, source: &str) -> Result<(v1::Stations, Turn), StreamError> {
        let asked = v1::GetStationsRequest { scene: self.scene.clone(), source: source.to_owned() };
        let request = |channel| {
            let request = asked.clone();
            async move { PointServiceClient::new(channel).get_stations(request).await }
        };
        let read = |answer: v1::GetStationsResponse| Ok(answer.stations.unwrap_or_default());
        self.ask("GetStations", request, read).await
    }

    /// What `read` makes of the answer to a call of one message, and the server whose turn it was. Where
    /// that fails, or what it says is no answer, the next one is asked, as often as there are servers
    /// and once more.
    async fn ask<M: Message, T, F>(
        &self,
        call: &'static str,
        request: impl Fn(Listened) -> F,
        read: impl Fn(M) -> Result<T, FieldError>,
    ) -> Result<(T, Turn), StreamError>
    where
        F: Future<Output = Result<Response<M>, Status>>,
    {
        let mut tries = 0;
        loop {
            let (turn, channel) = self.turn(call).await?;
            self.traffic.request();
            let answer = self.judged(turn, self.heard.in_time(call, request(channel)).await);
            let answer = answer.and_then(|answer| {
                let message = answer.into_inner();
                self.traffic.received(message.encoded_len());
                self.believed(call, turn, read(message))
            });
            match answer {
                Err(error) if error.is_server_at_fault() && tries < self.servers.count() => {
                    tries += 1;
                }
                Ok(answer) => {
                    self.servers.works(turn);
                    return Ok((answer, turn));
                }
                Err(refused) => return Err(refused),
            }
        }
    }

    /// What was read of an answer; a server that sends what is none is not asked for a while.
    fn believed<T>(
        &self,
        call: &'static str,
        turn: Turn,
        read: Result<T, FieldError>,
    ) -> Result<T, StreamError> {
        read.map_err(|error| {
            self.servers.fails(turn);
            StreamError::field(call)(error)
        })
    }

    /// Starts a streaming call once there is room for it.
    async fn open<M, F>(
        &self,
        call: &'static str,
        request: impl FnOnce(Listened) -> F,
    ) -> Result<Incoming<M>, StreamError>
    where
        F: Future<Output = Result<Response<tonic::Streaming<M>>, Status>>,
    {
        let permit = Arc::clone(&self.calls).acquire_owned().await;
        let permit = permit.expect("the semaphore is never closed");
        let (turn, channel) = self.turn(call).await?;
        self.traffic.request();
        let response = self.judged(turn, self.heard.in_time(call, request(channel)).await)?;
        Ok(Incoming::new(call, response.into_inner(), self.clone(), turn, permit))
    }

    async fn turn(&self, call: &'static str) -> Result<(Turn, Listened), StreamError> {
        let none = || StreamError::status(call)(Status::unavailable("there is no server to ask"));
        let (turn, channel) = self.servers.turn().await.ok_or_else(none)?;
        Ok((turn, self.heard.of(channel)))
    }

    /// The outcome of a call, or of a piece of one, after its server was blamed for it where it is at
    /// fault. Credit is given for what is whole: headers and pieces come through a connection, too, that
    /// breaks every time.
    fn judged<T>(&self, turn: Turn, outcome: Result<T, StreamError>) -> Result<T, StreamError> {
        match &outcome {
            Err(error) if error.is_server_at_fault() => self.servers.fails(turn),
            Err(_) => self.servers.works(turn),
            Ok(_) => {}
        }
        outcome
    }
}

/// The entries of a page.
pub(crate) fn entries(page: v1::HierarchyPage) -> Result<Vec<HierarchyEntry>, FieldError> {
    let within = |(index, entry)| {
        checked(entry).map_err(|e: FieldError| e.within(format_args!("entries[{index}]")))
    };
    page.entries.into_iter().enumerate().map(within).collect()
}

fn checked(entry: v1::HierarchyEntry) -> Result<HierarchyEntry, FieldError> {
    if !entry.is_page {
        return Ok(HierarchyEntry::Node(Node::try_from(entry)?));
    }
    let key = entry.key.ok_or_else(|| FieldError::new("key", "is absent"))?;
    Ok(HierarchyEntry::Page(NodeKey::try_from(key).map_err(|e| e.within("key"))?))
}

fn bounded(
    call: &'static str,
    what: &'static str,
    count: usize,
    limit: usize,
) -> Result<(), StreamError> {
    if count > limit { Err(StreamError::TooMuch { call, what, limit }) } else { Ok(()) }
}

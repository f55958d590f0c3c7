//! The clients: those of one connection are of one kind.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use flaneur_proto::v1;
use flaneur_scene::{Region, SceneInfo};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tonic::transport::{Channel, Endpoint};
use tonic::{Code, Status, Streaming};
use tonic_types::StatusExt;

use crate::Phase;
use v1::footprint_service_client::FootprintServiceClient;
use v1::ground_service_client::GroundServiceClient;
use v1::panorama_service_client::PanoramaServiceClient;
use v1::scene_service_client::SceneServiceClient;

/// Bytes that may be under way, by stream and by connection: little, and so much that streams that
/// nobody reads leave room for the others.
const WINDOW: (u32, u32) = (64 << 10, 1 << 20);

/// Metres around a walker.
const NEAR_M: f64 = 50.0;

/// Photographs of a request.
const PHOTOGRAPHS: usize = 200;

/// Steps of a walk begin so far apart at least.
const STEP: Duration = Duration::from_secs(20);

/// Slow readers take a message so often.
const DAWDLE: Duration = Duration::from_secs(5);

/// How long those that vanish stay, and stay away.
const VANISH: Duration = Duration::from_secs(2);

/// How long a call may take. The slowest readers are not held to it.
const IN_TIME: Duration = Duration::from_secs(20);

/// What is asked of the server.
pub(crate) struct Target {
    url: String,
    scene: SceneInfo,
    /// The finest level of photographs.
    fine: Vec<v1::ImageKey>,
    /// The coarsest levels of some.
    coarse: Vec<v1::ImageKey>,
}

/// What clients have seen.
#[derive(Default)]
pub(crate) struct Counts {
    holding: AtomicUsize,
    calls: AtomicU64,
    bytes: AtomicU64,
    refused: AtomicU64,
    late: AtomicU64,
    failed: AtomicU64,
}

/// The clients of one connection.
pub(crate) struct Group {
    number: usize,
    members: usize,
    target: Arc<Target>,
    counts: Arc<Counts>,
    phase: watch::Receiver<Phase>,
}

/// What the clients of a group do.
#[derive(Clone, Copy)]
enum Kind {
    /// Asks for what a few steps need, now and then.
    Walks,
    /// Takes a message now and then.
    Dawdles,
    /// Takes nothing more.
    Sleeps,
    /// Loses its connection amid an answer, and comes back.
    Vanishes,
}

impl Target {
    /// Finds out what there is to ask for.
    pub(crate) async fn explore(url: String, scene: &str) -> anyhow::Result<Self> {
        let channel = Endpoint::new(url.clone())?.connect().await?;
        let request = v1::GetSceneRequest { scene: scene.into() };
        let answer = SceneServiceClient::new(channel.clone()).get_scene(request).await?;
        let info = SceneInfo::try_from(answer.into_inner().scene.unwrap_or_default())
            .map_err(|error| anyhow::anyhow!("{error}"))?;
        let request = v1::StreamPanoramasRequest::new(scene, Region::All);
        let mut panoramas =
            PanoramaServiceClient::new(channel).stream_panoramas(request).await?.into_inner();
        let (mut fine, mut coarse) = (Vec::new(), Vec::new());
        while let Some(panorama) = panoramas.message().await? {
            for camera in &panorama.cameras {
                let key = |level| v1::ImageKey {
                    panorama: panorama.id.clone(),
                    camera: camera.id.clone(),
                    level,
                    layer: v1::ImageLayer::Colour.into(),
                };
                fine.push(key(0));
                coarse.push(key(camera.levels.len() as u32 - 1));
            }
        }
        anyhow::ensure!(!fine.is_empty(), "the scene has no photographs");
        fine = fine.iter().cycle().take(PHOTOGRAPHS).cloned().collect();
        coarse.truncate(6);
        Ok(Self { url, scene: info, fine, coarse })
    }

    /// More photographs than any client takes.
    pub(crate) async fn photographs(
        &self,
        channel: Channel,
    ) -> Result<Streaming<v1::ImagePart>, Status> {
        self.images(channel, self.fine.clone()).await
    }

    async fn images(
        &self,
        channel: Channel,
        images: Vec<v1::ImageKey>,
    ) -> Result<Streaming<v1::ImagePart>, Status> {
        let request = v1::StreamImagesRequest { scene: self.scene.name.clone(), images };
        Ok(PanoramaServiceClient::new(channel).stream_images(request).await?.into_inner())
    }

    async fn connect(&self) -> Result<Channel, tonic::transport::Error> {
        Endpoint::new(self.url.clone())?
            .initial_stream_window_size(WINDOW.0)
            .initial_connection_window_size(WINDOW.1)
            .connect()
            .await
    }
}

/// Whether a refusal says when to try again.
pub(crate) fn is_hinted(status: &Status) -> bool {
    let hint = status.get_details_retry_info().and_then(|info| info.retry_delay);
    status.code() == Code::ResourceExhausted && hint.is_some()
}

impl Counts {
    pub(crate) fn holding(&self) -> usize {
        self.holding.load(Ordering::Relaxed)
    }

    pub(crate) fn calls(&self) -> u64 {
        self.calls.load(Ordering::Relaxed)
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    fn received(&self, message: &impl prost::Message) {
        self.bytes.fetch_add(message.encoded_len() as u64, Ordering::Relaxed);
    }

    fn note(&self, outcome: Result<Result<(), Status>, tokio::time::error::Elapsed>) {
        let counter = match outcome {
            Ok(Ok(())) => &self.calls,
            Ok(Err(status)) if status.code() == Code::ResourceExhausted => &self.refused,
            Ok(Err(_)) => &self.failed,
            Err(_) => &self.late,
        };
        counter.fetch_add(1, Ordering::Relaxed);
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let get = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let [calls, refused] = [get(&self.calls), get(&self.refused)];
        let [failed, late] = [get(&self.failed), get(&self.late)];
        write!(f, "walkers: {calls} calls whole, {refused} refused, {failed} failed, {late} late")
    }
}

impl Group {
    pub(crate) fn new(
        number: usize,
        members: usize,
        target: Arc<Target>,
        counts: Arc<Counts>,
        phase: watch::Receiver<Phase>,
    ) -> Self {
        Self { number, members, target, counts, phase }
    }

    /// Lives until all are told to leave.
    pub(crate) async fn run(self) {
        let kind = match self.number % 10 {
            0..6 => Kind::Walks,
            6 | 7 => Kind::Dawdles,
            8 => Kind::Sleeps,
            _ => Kind::Vanishes,
        };
        let mut phase = self.phase.clone();
        tokio::select! {
            () = self.live(kind) => {}
            _ = phase.wait_for(|phase| *phase == Phase::Leave) => {}
        }
    }

    async fn live(&self, kind: Kind) {
        let Some(channel) = self.connected().await else { return };
        let mut held = Vec::new();
        for _ in 0..self.members {
            let opened = async {
                let mut stream = self.target.photographs(channel.clone()).await?;
                let part = stream.message().await?;
                Ok((stream, part))
            };
            match opened.await {
                Ok((stream, Some(part))) => {
                    self.counts.received(&part);
                    self.counts.holding.fetch_add(1, Ordering::Relaxed);
                    held.push(stream);
                }
                Ok((_, None)) => {}
                Err(status) => {
                    eprintln!("a stream could not be opened: {status:?}");
                    self.counts.note(Ok(Err(status)));
                }
            }
        }
        if self.phase.clone().wait_for(|phase| *phase != Phase::Hold).await.is_err() {
            return;
        }
        match kind {
            Kind::Walks => {
                drop(held);
                let mut walkers = JoinSet::new();
                for member in 0..self.members {
                    let seed = (self.number * self.members + member) as u64;
                    let (target, counts) = (self.target.clone(), self.counts.clone());
                    walkers.spawn(walk(seed, channel.clone(), target, counts));
                }
                while walkers.join_next().await.is_some() {}
            }
            Kind::Dawdles => loop {
                for stream in &mut held {
                    if let Ok(Ok(Some(part))) =
                        tokio::time::timeout(IN_TIME, stream.message()).await
                    {
                        self.counts.received(&part);
                    }
                }
                tokio::time::sleep(DAWDLE).await;
            },
            Kind::Sleeps => std::future::pending::<()>().await,
            Kind::Vanishes => {
                drop((held, channel));
                // Not all at the same moment.
                tokio::time::sleep(VANISH.mul_f64((self.number % 100) as f64 / 50.0)).await;
                loop {
                    let Some(channel) = self.connected().await else { return };
                    let mut held = Vec::new();
                    for _ in 0..self.members {
                        if let Ok(stream) = self.target.photographs(channel.clone()).await {
                            held.push(stream);
                        }
                    }
                    tokio::time::sleep(VANISH).await;
                    drop((held, channel));
                    tokio::time::sleep(VANISH).await;
                }
            }
        }
    }

    /// A connection, as soon as one can be had.
    async fn connected(&self) -> Option<Channel> {
        for _ in 0..100 {
            if let Ok(channel) = self.target.connect().await {
                return Some(channel);
            }
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
        None
    }
}

/// Walks along the scene, from a place of its own, until it is dropped.
async fn walk(seed: u64, channel: Channel, target: Arc<Target>, counts: Arc<Counts>) {
    let bounds = target.scene.bounds.plan();
    for step in 0_u64.. {
        // Thousands of walkers do not step at the same moment.
        let place = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(step as u32);
        let share = (place >> 11) as f64 / (1_u64 << 53) as f64;
        let pause = if step == 0 { STEP.mul_f64(share) } else { STEP };
        tokio::time::sleep(pause).await;
        let centre = bounds.min + (bounds.max - bounds.min) * share;
        let near = Region::Disc { centre, radius_m: NEAR_M };
        let name = target.scene.name.as_str();
        counts.note(tokio::time::timeout(IN_TIME, ground(&channel, name, near, &counts)).await);
        counts.note(tokio::time::timeout(IN_TIME, footprints(&channel, name, near, &counts)).await);
        let images = async {
            let mut parts = target.images(channel.clone(), target.coarse.clone()).await?;
            while let Some(part) = parts.message().await? {
                counts.received(&part);
            }
            Ok(())
        };
        counts.note(tokio::time::timeout(IN_TIME, images).await);
    }
}

async fn ground(
    channel: &Channel,
    scene: &str,
    near: Region,
    counts: &Counts,
) -> Result<(), Status> {
    let request = v1::StreamGroundRequest { step: 4, ..v1::StreamGroundRequest::new(scene, near) };
    let mut client = GroundServiceClient::new(channel.clone());
    let mut tiles = client.stream_ground(request).await?.into_inner();
    while let Some(tile) = tiles.message().await? {
        counts.received(&tile);
    }
    Ok(())
}

async fn footprints(
    channel: &Channel,
    scene: &str,
    near: Region,
    counts: &Counts,
) -> Result<(), Status> {
    let request = v1::StreamFootprintsRequest {
        geometry_only: true,
        ..v1::StreamFootprintsRequest::new(scene, near)
    };
    let mut client = FootprintServiceClient::new(channel.clone());
    let mut batches = client.stream_footprints(request).await?.into_inner();
    while let Some(batch) = batches.message().await? {
        counts.received(&batch);
    }
    Ok(())
}

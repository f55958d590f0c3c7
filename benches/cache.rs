//! Which share of a walk's requests a cache answers: the streamer's, beside a plain
//! least-recently-used list and segmented lists whose probation is small whatever a view uses.
//!
//! ```text
//! cargo bench --bench cache -- STORE SCENE
//! ```
//!
//! The walk goes along the scene's panoramas, there and back, twice, with a view every metre. What
//! the streamer asks for at each is recorded, with the bytes of its compressed form; the
//! caches are then fed with the record.

use std::collections::{BTreeMap, HashMap};
use std::hint::black_box;
use std::time::Instant;

use flaneur_proto::v1;
use flaneur_proto::v1::point_service_client::PointServiceClient;
use flaneur_scene::{ImageId, NodeKey, Panorama, PointNodeId, Region, SceneUpdate, View};
use flaneur_services::grpc::in_process;
use flaneur_services::store::{Catalog, Store};
use flaneur_streamer::{Event, Rank, SegmentedLru, Streamer, ViewRequest};
use futures::TryStreamExt;
use glam::{DVec3, UVec2};
use tokio_util::sync::CancellationToken;
use tonic::transport::Channel;

/// Distance between two views, metres.
const STEP_M: f64 = 1.0;
/// Nodes up to this level are coarse enough to be protected at once.
const UPPER_LEVEL: u32 = 1;
/// Capacities, in parts of what the largest view uses.
const CAPACITIES: [f64; 8] = [0.5, 0.75, 0.9, 1.0, 1.1, 1.5, 2.0, 3.0];

/// A part of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Part {
    /// An image, by its place among all, at a level.
    Image(usize, u32),
    Node(PointNodeId),
}

/// A request for a part: what it is, its bytes, its rank.
type Request = (Part, u64, Rank);

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let [store, scene] = arguments.as_slice() else {
        println!("usage: cargo bench --bench cache -- STORE SCENE");
        return Ok(());
    };
    let channel = in_process(Catalog::open([Store::open_existing(store)?]).await?).await?;
    let walk = Walk::record(channel, scene).await?;
    let shown: Vec<u64> = walk.whole_views.iter().map(|view| bytes(view)).collect();
    let largest = shown.iter().copied().max().unwrap_or(0);
    println!(
        "{} views of {scene}; the largest uses {} parts, {:.1} MB",
        walk.whole_views.len(),
        walk.whole_views.iter().map(Vec::len).max().unwrap_or(0),
        largest as f64 / 1e6
    );
    for (what, views) in [
        ("every view asks for all that it shows", &walk.whole_views),
        ("every view asks for what the view before had not", &walk.new_parts),
    ] {
        let requests: usize = views.iter().map(Vec::len).sum();
        let all: u64 = views.iter().map(|view| bytes(view)).sum();
        println!("\n{what}: {requests} requests, {:.1} MB; share of hits, %", all as f64 / 1e6);
        let columns = CAPACITIES.map(|share| format!("{share:>6.2}"));
        println!("{:<36} {}", "capacity, largest views", columns.join(" "));
        for policy in Policy::ALL {
            let shares = CAPACITIES.map(|share| {
                let capacity = (share * largest as f64) as u64;
                format!("{:>6.1}", 100.0 * policy.hits(capacity, views, &shown))
            });
            println!("{:<36} {}", policy.name(), shares.join(" "));
        }
    }
    println!("\none lookup, with an insertion where it misses: {:.0} ns", cost_ns(&walk, &shown));
    Ok(())
}

/// How entries are kept.
#[derive(Clone, Copy)]
enum Policy {
    Plain,
    /// Two segments of fixed size: probation has this share.
    Fixed(f64),
    /// The streamer's, told at each view what that shows.
    OursByShown,
    /// The streamer's, told at each view what that asks for.
    OursByAsked,
}

impl Policy {
    const ALL: [Self; 5] =
        [Self::Plain, Self::Fixed(0.05), Self::Fixed(0.2), Self::OursByShown, Self::OursByAsked];

    fn name(self) -> String {
        match self {
            Self::Plain => "least recently used".into(),
            Self::Fixed(share) => format!("segmented, probation {:.0} %", 100.0 * share),
            Self::OursByShown => "ours, probation ≥ what a view shows".into(),
            Self::OursByAsked => "ours, ≥ what it asks for".into(),
        }
    }

    /// Share of requests that find what they ask for.
    fn hits(self, capacity: u64, views: &[Vec<Request>], shown: &[u64]) -> f64 {
        let probation = match self {
            Self::Plain => capacity,
            Self::Fixed(share) => (share * capacity as f64) as u64,
            Self::OursByShown => return ours(capacity, views, shown),
            Self::OursByAsked => {
                let asked: Vec<u64> = views.iter().map(|view| bytes(view)).collect();
                return ours(capacity, views, &asked);
            }
        };
        let mut list = Fixed { probation: Queue::default(), protected: Queue::default() };
        let limits = (probation, capacity - probation);
        let (mut hits, mut requests) = (0_u64, 0_u64);
        for &request in views.iter().flatten() {
            requests += 1;
            hits += u64::from(list.request(request, limits));
        }
        hits as f64 / requests.max(1) as f64
    }
}

/// The streamer's own list, told at each view its working set.
fn ours(capacity: u64, views: &[Vec<Request>], working_sets: &[u64]) -> f64 {
    let mut list = SegmentedLru::new(capacity);
    let (mut hits, mut requests) = (0_u64, 0_u64);
    for (view, &working_set) in views.iter().zip(working_sets) {
        list.set_working_set(working_set);
        for &(part, bytes, rank) in view {
            requests += 1;
            match list.get(&part) {
                Some(()) => hits += 1,
                None => list.insert(part, (), bytes, rank),
            }
        }
    }
    hits as f64 / requests.max(1) as f64
}

/// A segmented list as it is usually described, written for this comparison: two queues, each with
/// a size of its own.
struct Fixed {
    probation: Queue,
    protected: Queue,
}

impl Fixed {
    /// Whether the part is there; it is from then on.
    fn request(&mut self, request: Request, limits: (u64, u64)) -> bool {
        let (part, bytes, rank) = request;
        let hit = self.probation.take(part) | self.protected.take(part);
        let protect = (hit || rank == Rank::Upper) && bytes <= limits.1;
        let queue = if protect { &mut self.protected } else { &mut self.probation };
        queue.push(part, bytes);
        while self.protected.bytes > limits.1 {
            let (part, bytes) = self.protected.pop();
            self.probation.push(part, bytes);
        }
        while self.probation.bytes > limits.0 {
            self.probation.pop();
        }
        hit
    }
}

/// Parts by when they were last used.
#[derive(Default)]
struct Queue {
    by_part: HashMap<Part, (u64, u64)>,
    by_use: BTreeMap<u64, Part>,
    uses: u64,
    bytes: u64,
}

impl Queue {
    fn push(&mut self, part: Part, bytes: u64) {
        self.uses += 1;
        self.by_part.insert(part, (self.uses, bytes));
        self.by_use.insert(self.uses, part);
        self.bytes += bytes;
    }

    fn take(&mut self, part: Part) -> bool {
        let Some((used, bytes)) = self.by_part.remove(&part) else { return false };
        self.by_use.remove(&used);
        self.bytes -= bytes;
        true
    }

    /// The part used longest ago. There must be one.
    fn pop(&mut self) -> (Part, u64) {
        let (_, part) = self.by_use.pop_first().expect("bytes are of parts");
        let (_, bytes) = self.by_part.remove(&part).expect("both or neither");
        self.bytes -= bytes;
        (part, bytes)
    }
}

/// Time of one request to a list of 1.5 views, nanoseconds.
fn cost_ns(walk: &Walk, shown: &[u64]) -> f64 {
    let requests: usize = walk.whole_views.iter().map(Vec::len).sum();
    let capacity = 3 * shown.iter().copied().max().unwrap_or(0) / 2;
    let started = Instant::now();
    black_box(ours(capacity, black_box(&walk.whole_views), shown));
    started.elapsed().as_secs_f64() * 1e9 / requests.max(1) as f64
}

fn bytes(requests: &[Request]) -> u64 {
    requests.iter().map(|(_, bytes, _)| bytes).sum()
}

/// What was asked for, view by view.
struct Walk {
    /// All parts that each view shows, coarse to fine.
    whole_views: Vec<Vec<Request>>,
    /// Those that the receiver of the view before did not hold, in the order in which they came.
    new_parts: Vec<Vec<Request>>,
}

impl Walk {
    async fn record(channel: Channel, scene: &str) -> anyhow::Result<Self> {
        let mut streamer = Streamer::connect(channel.clone(), scene).await?;
        let panoramas: Vec<Panorama> =
            streamer.client().panoramas(Region::All).await?.try_collect().await?;
        let images = Images::of(&panoramas)?;
        let nodes = nodes(channel, scene, &streamer).await?;
        let mut walk = Self { whole_views: Vec::new(), new_parts: Vec::new() };
        let mut held: BTreeMap<Part, Request> = BTreeMap::new();
        for view in views(&panoramas) {
            let mut new = Vec::new();
            let mut events = streamer.stream(ViewRequest::new(view), &CancellationToken::new());
            while let Some(event) = events.try_next().await? {
                let Event::Update(update) = event else { continue };
                let request = match update {
                    SceneUpdate::Image(image) => images.request(&image.id, image.level),
                    SceneUpdate::Points(chunk) => {
                        let level = chunk.id.key.level;
                        let rank = if level <= UPPER_LEVEL { Rank::Upper } else { Rank::Detail };
                        nodes.get(&chunk.id).map(|&bytes| (Part::Node(chunk.id), bytes, rank))
                    }
                    SceneUpdate::DropImage(id) => {
                        let gone = images.places.get(&id);
                        held.retain(
                            |part, _| !matches!(part, Part::Image(i, _) if Some(i) == gone),
                        );
                        continue;
                    }
                    SceneUpdate::DropPoints(id) => {
                        held.remove(&Part::Node(id));
                        continue;
                    }
                    SceneUpdate::Mesh(_) | SceneUpdate::DropMesh(_) => continue,
                };
                // Several faces come of one image.
                if let Some(request) = request
                    && !new.contains(&request)
                {
                    new.push(request);
                    held.insert(request.0, request);
                }
            }
            walk.new_parts.push(new);
            // Coarse to fine: what is protected at once, then nodes by level, then images.
            let mut whole: Vec<Request> = held.values().copied().collect();
            whole.sort_by_key(|(part, _, rank)| match part {
                Part::Node(id) => (*rank == Rank::Detail, id.key.level, *part),
                Part::Image(..) => (*rank == Rank::Detail, u32::MAX, *part),
            });
            walk.whole_views.push(whole);
        }
        Ok(walk)
    }
}

/// Views along the panoramas, there and back, twice, looking where the walk goes.
fn views(panoramas: &[Panorama]) -> Vec<View> {
    let mut panoramas: Vec<&Panorama> = panoramas.iter().collect();
    panoramas.sort_by(|a, b| a.id.cmp(&b.id));
    // One vehicle: others took the same street on another day.
    let cameras = panoramas.first().map_or(0, |panorama| panorama.cameras.len());
    panoramas.retain(|panorama| panorama.cameras.len() == cameras);
    let mut eyes: Vec<DVec3> = Vec::new();
    let mut rest = 0.0;
    for pair in panoramas.windows(2) {
        let (from, to) = (pair[0].position, pair[1].position);
        let length = from.distance(to);
        while rest < length {
            eyes.push(from.lerp(to, rest / length));
            rest += STEP_M;
        }
        rest -= length;
    }
    let way = |pair: &[DVec3]| {
        let along = pair[1] - pair[0];
        View::look(pair[0], along.x.atan2(along.y), 0.0, 1.2, UVec2::new(1024, 512))
    };
    let there: Vec<View> = eyes.windows(2).map(way).collect();
    eyes.reverse();
    let back: Vec<View> = eyes.windows(2).map(way).collect();
    [there.clone(), back.clone(), there, back].concat()
}

/// Stored images: the photographs that come of each, and the bytes of its levels.
struct Images {
    places: HashMap<ImageId, usize>,
    bytes: Vec<Vec<u64>>,
}

impl Images {
    fn of(panoramas: &[Panorama]) -> anyhow::Result<Self> {
        let mut images = Self { places: HashMap::new(), bytes: Vec::new() };
        for panorama in panoramas {
            // Photographs follow the order of their cameras; a sphere gives six.
            let photographs = panorama.photographs()?;
            let each = photographs.len() / panorama.cameras.len().max(1);
            let first = images.bytes.len();
            for (at, (id, _)) in photographs.into_iter().enumerate() {
                images.places.insert(id, first + at / each.max(1));
            }
            for camera in &panorama.cameras {
                images.bytes.push(camera.levels.iter().map(|level| level.bytes).collect());
            }
        }
        Ok(images)
    }

    fn request(&self, id: &ImageId, level: u32) -> Option<Request> {
        let place = *self.places.get(id)?;
        let levels = self.bytes.get(place)?;
        let bytes = *levels.get(level as usize)?;
        // The level that is shown until the finer one has come: tens of kilobytes less.
        let rank = if level as usize + 2 >= levels.len() { Rank::Upper } else { Rank::Detail };
        Some((Part::Image(place, level), bytes, rank))
    }
}

/// The bytes of every node.
async fn nodes(
    channel: Channel,
    scene: &str,
    streamer: &Streamer,
) -> anyhow::Result<HashMap<PointNodeId, u64>> {
    let mut client = PointServiceClient::new(channel);
    let mut nodes = HashMap::new();
    for (source, name) in (0_u16..).zip(streamer.info().point_sources.iter().map(|s| &s.name)) {
        let (scene, source_name) = (scene.to_owned(), name.clone());
        let request = v1::GetHierarchyRequest { scene, source: source_name, page: None };
        let mut pages = client.get_hierarchy(request).await?.into_inner();
        while let Some(page) = pages.message().await? {
            for entry in page.entries {
                let Some(key) = entry.key else { continue };
                let id = PointNodeId { source, key: NodeKey::try_from(key)? };
                nodes.insert(id, u64::from(entry.byte_size));
            }
        }
    }
    Ok(nodes)
}

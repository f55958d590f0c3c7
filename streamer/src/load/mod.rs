//! From parts to payloads: out of the cache, from a fetch that is under way for someone else, or over
//! the network.

mod window;
mod wire;

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use bytes::Bytes;
use flaneur_scene::SceneInfo;
use futures::StreamExt;
use futures::stream::FuturesUnordered;
use tokio::sync::{Notify, mpsc, watch};
use tokio::time::Instant;
use tokio_util::sync::{CancellationToken, DropGuard};

use crate::StreamError;
use crate::cache::{Cache, CacheKey, Checked, Rank};
use crate::client::Client;
use crate::plan::{BatchId, Part, Room};
use crate::servers::Turn;
use crate::survey::Target;
use window::Window;

/// Octree levels that count as upper ones: they are wanted from wherever one stands.
const UPPER_LEVELS: u32 = 2;
/// The longest file that counts as an upper one.
const UPPER_BYTES: u64 = 32 << 10;

/// Fetches what several receivers of one scene want. What two of them want at once comes once.
#[derive(Debug)]
pub(crate) struct Loader {
    client: Client,
    scene: Arc<SceneInfo>,
    cache: Cache,
    window: Mutex<Window>,
    flights: Mutex<HashMap<Part, Flight>>,
    freed: Arc<Notify>,
}

/// A part that came, or did not.
#[derive(Debug)]
pub(crate) struct Landed {
    /// Of which batch.
    pub(crate) batch: BatchId,
    /// Which.
    pub(crate) part: Part,
    /// Its payload, checked against what is known of it.
    pub(crate) payload: Result<Bytes, StreamError>,
    /// Where that came from.
    pub(crate) origin: Origin,
}

/// Where a payload came from.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Origin {
    /// The server that sent it; `None` out of the cache.
    turn: Option<Turn>,
    /// Whether it was asked for by this batch, rather than by someone else's or before.
    pub(crate) fetched: bool,
}

/// Interest in some parts. Once nobody is interested in a request any more it ends on the wire.
#[derive(Debug)]
pub(crate) struct Interest {
    _stop: DropGuard,
}

/// A part under way.
#[derive(Clone, Debug)]
struct Flight {
    request: Weak<DropGuard>,
    payload: watch::Receiver<Came>,
}

impl Loader {
    pub(crate) fn new(client: Client, scene: Arc<SceneInfo>, cache: Cache) -> Self {
        Self {
            client,
            scene,
            cache,
            window: Mutex::default(),
            flights: Mutex::default(),
            freed: Arc::default(),
        }
    }

    /// The scene that the parts are of.
    pub(crate) fn scene(&self) -> &Arc<SceneInfo> {
        &self.scene
    }

    /// For calls beside the parts.
    pub(crate) fn client(&self) -> &Client {
        &self.client
    }

    /// What was fetched before.
    pub(crate) fn cache(&self) -> &Cache {
        &self.cache
    }

    /// What may be asked for at once now; `None` where enough is under way.
    pub(crate) fn room(&self) -> Option<Room> {
        lock(&self.window).room()
    }

    /// Tells when there may be more room, whoever made it.
    pub(crate) fn freed(&self) -> Arc<Notify> {
        Arc::clone(&self.freed)
    }

    /// Forgets a payload that turned out to be of no use. Who sent it is not asked for a while.
    pub(crate) fn reject(&self, part: &Part, origin: Origin) {
        self.cache.remove(&self.key(part));
        if let Some(turn) = origin.turn {
            self.client.servers().fails(turn);
        }
    }

    /// Has `parts` brought, all of one kind and about `bytes` long, each sent to `sink` as it comes, for
    /// as long as the interest is held.
    pub(crate) fn load(
        self: &Arc<Self>,
        batch: BatchId,
        parts: Vec<(Part, Target)>,
        bytes: u64,
        sink: mpsc::UnboundedSender<Landed>,
    ) -> Interest {
        let stop = CancellationToken::new();
        let (this, stopped) = (Arc::clone(self), stop.clone());
        // At once: who asks next must see that there is less room.
        let place = InWindow::new(self, bytes);
        tokio::spawn(async move {
            tokio::select! {
                () = stopped.cancelled() => {}
                () = this.bring(batch, parts, place, &sink) => {}
            }
        });
        Interest { _stop: stop.drop_guard() }
    }

    async fn bring(
        self: Arc<Self>,
        batch: BatchId,
        parts: Vec<(Part, Target)>,
        place: InWindow,
        sink: &mpsc::UnboundedSender<Landed>,
    ) {
        let mut absent = Vec::new();
        for (part, target) in parts {
            match self.cache.get(&self.key(&part), expected(&target)).await {
                Some(payload) => {
                    place.skip(&target);
                    // Where nobody listens, nobody needs to know.
                    let (payload, origin) = (Ok(payload), Origin::default());
                    drop(sink.send(Landed { batch, part, payload, origin }));
                }
                None => absent.push((part, target)),
            }
        }
        let (flights, _alive) = self.join(absent, place);
        let mut flights: FuturesUnordered<_> = flights
            .into_iter()
            .map(|Joined { part, mut payload, fetched }| async move {
                let outcome = payload.wait_for(Option::is_some).await;
                let outcome = outcome.ok().and_then(|outcome| outcome.clone());
                let (payload, turn) = match outcome.unwrap_or(Err(StreamError::Cancelled)) {
                    Ok((payload, turn)) => (Ok(payload), turn),
                    Err(error) => (Err(error), None),
                };
                Landed { batch, part, payload, origin: Origin { turn, fetched } }
            })
            .collect();
        while let Some(landed) = flights.next().await {
            drop(sink.send(landed));
        }
    }

    /// The flights of `parts`: those under way, and a new request for the others. They go on while any
    /// of the guards lives.
    fn join(
        self: &Arc<Self>,
        parts: Vec<(Part, Target)>,
        place: InWindow,
    ) -> (Vec<Joined>, Vec<Arc<DropGuard>>) {
        let mut flights = lock(&self.flights);
        let (mut joined, mut alive) = (Vec::new(), Vec::new());
        let (mut own, mut senders) = (Vec::new(), HashMap::new());
        let cancel = CancellationToken::new();
        let request = Arc::new(cancel.clone().drop_guard());
        for (part, target) in parts {
            let under_way = flights
                .get(&part)
                .and_then(|flight| Some((flight.request.upgrade()?, flight.payload.clone())));
            if let Some((request, payload)) = under_way {
                place.skip(&target);
                alive.push(request);
                joined.push(Joined { part, payload, fetched: false });
                continue;
            }
            // It may have landed since the cache was asked.
            if let Some(payload) = self.cache.at_hand(&self.key(&part)) {
                place.skip(&target);
                let payload = watch::channel(Some(Ok((payload, None)))).1;
                joined.push(Joined { part, payload, fetched: false });
                continue;
            }
            let (sender, receiver) = watch::channel(None);
            let flight = Flight { request: Arc::downgrade(&request), payload: receiver.clone() };
            flights.insert(part.clone(), flight);
            senders.insert(part.clone(), sender);
            joined.push(Joined { part: part.clone(), payload: receiver, fetched: true });
            own.push((part, target));
        }
        if !own.is_empty() {
            alive.push(request);
            let this = Arc::clone(self);
            tokio::spawn(async move { this.fly(own, senders, place, cancel).await });
        }
        (joined, alive)
    }

    /// Fetches `parts` over the network until it is cancelled.
    async fn fly(
        self: Arc<Self>,
        parts: Vec<(Part, Target)>,
        senders: Senders,
        place: InWindow,
        cancel: CancellationToken,
    ) {
        let land = |part: &Part, turn, payload: Result<Bytes, StreamError>| {
            if let Ok(payload) = &payload {
                place.received(payload.len() as u64);
                let rank = rank(part, payload);
                // Owns its bytes: a slice would keep a whole message.
                self.cache.insert(&self.key(part), payload.clone(), rank);
            }
            self.land(part, &senders, payload.map(|payload| (payload, Some(turn))));
        };
        let outcome = tokio::select! {
            biased;
            () = cancel.cancelled() => Err(StreamError::Cancelled),
            outcome = wire::fetch(&self.client, &self.scene, &parts, &land) => outcome,
        };
        let end = outcome.err().unwrap_or(StreamError::Cancelled);
        for (part, _) in &parts {
            // Those that have landed are left as they are.
            self.land(part, &senders, Err(end.clone()));
        }
    }

    fn land(&self, part: &Part, senders: &Senders, payload: Sent) {
        let Some(sender) = senders.get(part) else { return };
        let news = sender.send_if_modified(|landed| {
            let is_first = landed.is_none();
            if is_first {
                *landed = Some(payload);
            }
            is_first
        });
        if news {
            let mut flights = lock(&self.flights);
            // A flight that was given up may have a successor.
            let own = sender.subscribe();
            if flights.get(part).is_some_and(|flight| flight.payload.same_channel(&own)) {
                flights.remove(part);
            }
        }
    }

    fn key(&self, part: &Part) -> CacheKey {
        let (scene, version) = (&self.scene.name, &self.scene.version);
        let (kind, name) = match part {
            Part::Panoramas(district) => ("panoramas", format!("{district:?}")),
            Part::Page(id) => ("page", self.node(id)),
            Part::Stations(source) => ("stations", source.to_string()),
            Part::Mask(name) => ("mask", name.to_string()),
            Part::Mesh { key, step } => ("mesh", format!("{key:?} {step}")),
            Part::Image { panorama, camera, level } => {
                ("image", format!("{camera} {level} {panorama}"))
            }
            Part::Node(id) => ("node", self.node(id)),
        };
        CacheKey::new(scene, version, kind, &name)
    }

    fn node(&self, id: &flaneur_scene::PointNodeId) -> String {
        let key = id.key;
        format!("{} {} {} {} {}", id.source, key.level, key.x, key.y, key.z)
    }
}

/// A part that someone waits for.
struct Joined {
    part: Part,
    payload: watch::Receiver<Came>,
    fetched: bool,
}

/// A payload, and who sent it where someone did just now.
type Sent = Result<(Bytes, Option<Turn>), StreamError>;
/// `None` while it is under way.
type Came = Option<Sent>;
type Senders = HashMap<Part, watch::Sender<Came>>;

/// What is known of a part's payload before it comes.
pub(crate) fn expected(target: &Target) -> Option<Checked> {
    match target {
        Target::Named => None,
        Target::Mask(_, stored) => Some(Checked::from(*stored)),
        Target::Image(image, level) => {
            image.rig_camera().levels.get(*level as usize).map(|&stored| Checked::from(stored))
        }
        Target::Node(wanted) => Some(Checked::from(wanted.node)),
    }
}

/// What is likely to be wanted again wherever one goes.
fn rank(part: &Part, payload: &Bytes) -> Rank {
    let upper = match part {
        Part::Node(id) => id.key.level < UPPER_LEVELS,
        Part::Image { .. } => (payload.len() as u64) < UPPER_BYTES,
        Part::Panoramas(_) | Part::Page(_) | Part::Stations(_) | Part::Mask(_) => true,
        Part::Mesh { .. } => true,
    };
    if upper { Rank::Upper } else { Rank::Detail }
}

/// A request's place in the window, given back when it ends.
#[derive(Debug)]
struct InWindow {
    loader: Arc<Loader>,
    sent: Mutex<window::Sent>,
}

impl InWindow {
    fn new(loader: &Arc<Loader>, bytes: u64) -> Self {
        let sent = lock(&loader.window).send(bytes, Instant::now());
        Self { loader: Arc::clone(loader), sent: Mutex::new(sent) }
    }

    /// So many bytes came over the network.
    fn received(&self, bytes: u64) {
        lock(&self.loader.window).receive(&mut lock(&self.sent), bytes, Instant::now());
        self.loader.freed.notify_waiters();
    }

    /// A part does not come over the network.
    fn skip(&self, target: &Target) {
        let bytes = expected(target).map_or(0, |expected| expected.length);
        lock(&self.loader.window).forgo(&mut lock(&self.sent), bytes);
        self.loader.freed.notify_waiters();
    }
}

impl Drop for InWindow {
    fn drop(&mut self) {
        lock(&self.loader.window).end(&lock(&self.sent));
        self.loader.freed.notify_waiters();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

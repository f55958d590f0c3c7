//! Servers that die or fall silent, connections that break anywhere, networks that lose packets:
//! in the end the receiver holds what it would hold without, bit by bit.
//!
//! Servers are real processes. Nothing here waits for a time to pass: faults happen at counts of
//! bytes, and tests go on when they have happened.

mod holdings;
mod link;
mod lossy;
mod served;
mod street;

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::Duration;

use flaneur_scene::{Region, View};
use flaneur_services::grpc::in_process;
use flaneur_services::store::{Catalog, Store};
use flaneur_streamer::{
    CacheOptions, DiskOptions, Event, Progress, Servers, Statistics, StreamError, StreamOptions,
    Streamer, ViewRequest,
};
use futures::future::join;
use futures::{StreamExt, TryStreamExt};
use glam::UVec2;
use holdings::Holdings;
use link::{Fault, Link};
use served::Served;
use street::SampleStreet;
use tokio_util::sync::CancellationToken;
use tonic::transport::{Channel, Endpoint};

/// However bad it gets, streaming ends within this time.
const BOUND: Duration = Duration::from_secs(60);

/// What all tests look at.
struct Scene {
    store: PathBuf,
    request: ViewRequest,
    /// What a receiver holds without faults.
    expected: Holdings,
    /// Bytes that TCP then carries to the client.
    bytes: u64,
}

impl Scene {
    /// One scene serves all: making it takes longer than what is tested.
    fn shared() -> &'static Self {
        static SCENE: OnceLock<Scene> = OnceLock::new();
        SCENE.get_or_init(|| {
            let made = std::thread::spawn(|| {
                let runtime = tokio::runtime::Runtime::new().expect("a runtime");
                runtime.block_on(Self::made())
            });
            made.join().expect("a scene")
        })
    }

    async fn made() -> Self {
        // Two processes of this test may run at once, each with a scene of its own.
        let name = if lossy::within() { "faults-lossy" } else { "faults" };
        let street = SampleStreet::dense(name).await;
        let store = Store::open_existing(street.store.to_str().expect("text")).expect("ingested");
        let catalog = Catalog::open([store]).await.expect("ingested");
        let channel = in_process(catalog).await.expect("in process");
        let mut streamer = Streamer::connect(channel, "sample").await.expect("the scene");
        let panoramas = streamer.client().panoramas(Region::All).await.expect("there are some");
        let panoramas: Vec<_> = panoramas.try_collect().await.expect("sound");
        let first = panoramas.iter().min_by_key(|panorama| &panorama.id).expect("one");
        let view = View::look(first.position, 1.5, 0.05, 1.0, UVec2::new(320, 160));
        let request = ViewRequest::new(view);
        let (expected, _) = hold(&mut streamer, &request).await;
        assert!(expected.len() > 30, "{} tiles, photographs and nodes", expected.len());

        let server = Served::start(&[&street.store]);
        let link = Link::start(&server.url, []).await;
        let mut streamer = connect(&[&link.url]).await;
        let (held, statistics) = hold(&mut streamer, &request).await;
        assert_eq!(held.difference(&expected), [""; 0]);
        assert_eq!((statistics.retries, statistics.refetched, statistics.failovers), (0, 0, 0));
        Self { store: street.store, request, expected, bytes: link.delivered() }
    }

    fn server(&self) -> Served {
        Served::start(&[&self.store])
    }

    /// A copy of its store in which something has happened to every file whose name ends as said;
    /// those of which nothing is left are gone.
    fn copy(
        &self,
        suffix: &str,
        happens: impl Fn(Vec<u8>) -> Option<Vec<u8>>,
    ) -> tempfile::TempDir {
        let copy = tempfile::tempdir().expect("a folder");
        let mut folders = vec![PathBuf::new()];
        let mut changed = 0;
        while let Some(folder) = folders.pop() {
            fs::create_dir_all(copy.path().join(&folder)).expect("made");
            for entry in fs::read_dir(self.store.join(&folder)).expect("a folder") {
                let entry = entry.expect("readable");
                let name = folder.join(entry.file_name());
                if entry.path().is_dir() {
                    folders.push(name);
                    continue;
                }
                let bytes = fs::read(entry.path()).expect("readable");
                let is_one = name.to_string_lossy().ends_with(suffix);
                changed += usize::from(is_one);
                if let Some(bytes) = if is_one { happens(bytes) } else { Some(bytes) } {
                    fs::write(copy.path().join(name), bytes).expect("written");
                }
            }
        }
        assert!(changed > 0, "no file ends with {suffix:?}");
        copy
    }

    /// Streams to the end; what the receiver then holds must be what is expected.
    async fn arrives(&self, streamer: &mut Streamer, what: &str) -> Statistics {
        let (held, statistics) = hold(streamer, &self.request).await;
        assert_eq!(held.difference(&self.expected), [""; 0], "{what}: {statistics:?}");
        statistics
    }
}

fn channel(url: &str) -> Channel {
    Endpoint::new(url.to_owned()).expect("an address").connect_lazy()
}

async fn connect(urls: &[&str]) -> Streamer {
    connect_with(urls, StreamOptions::default()).await
}

async fn connect_with(urls: &[&str], options: StreamOptions) -> Streamer {
    let servers = Servers::from(urls.iter().map(|url| channel(url)).collect::<Vec<_>>());
    let connected = Streamer::connect_with(servers, "sample", options);
    within(connected).await.expect("the scene")
}

async fn within<T>(future: impl Future<Output = T>) -> T {
    tokio::time::timeout(2 * BOUND, future).await.expect("it ends")
}

/// Everything that the request wants, streamed to a receiver with empty hands.
async fn hold(streamer: &mut Streamer, request: &ViewRequest) -> (Holdings, Statistics) {
    let (held, statistics, faults) = hold_what_comes(streamer, request).await;
    assert_eq!(faults, [""; 0], "{statistics:?}");
    (held, statistics)
}

/// The same where something may not be had: also what was said of that.
async fn hold_what_comes(
    streamer: &mut Streamer,
    request: &ViewRequest,
) -> (Holdings, Statistics, Vec<String>) {
    let mut faults = Vec::new();
    let (mut held, mut last) = (Holdings::default(), Progress::default());
    let streaming = async {
        let view = streamer.look(request.clone());
        while !(last.view == view && last.finished) {
            match streamer.next().await {
                Event::Update(update) => held.apply(&update),
                Event::Fault { error, .. } => faults.push(error.to_string()),
                Event::Progress(progress) => last = progress,
            }
        }
    };
    if tokio::time::timeout(BOUND, streaming).await.is_err() {
        let (count, statistics) = (held.len(), streamer.statistics());
        panic!("after {BOUND:?}: {count} held, {last:?}, {statistics:?}");
    }
    (held, streamer.statistics(), faults)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_connection_may_break_anywhere() {
    let scene = Scene::shared();
    let server = scene.server();
    // In the first messages of HTTP/2, in headers, in the scene's description, and in payloads.
    let early = [0, 1, 9, 33, 100, 400, 1000, 3000].map(|at| (at, false));
    let late = (1..12_u64).map(|part| (scene.bytes * part / 12 + part, part > 4));
    for (at, is_payload) in early.into_iter().chain(late) {
        let link = Link::start(&server.url, [(at, Fault::Cut)]).await;
        let mut streamer = connect(&[&link.url]).await;
        let statistics = scene.arrives(&mut streamer, &format!("cut at {at}")).await;
        link.happened(1).await;
        assert!(!is_payload || statistics.retries > 0, "cut at {at}: {statistics:?}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_connection_may_break_again_and_again() {
    let scene = Scene::shared();
    let server = scene.server();
    // Each carries less than the one before, so that what was begun is never whole at once.
    let cuts = (0..8_u64).scan(0, |at, i| {
        *at += scene.bytes / (8 + 4 * i);
        Some((*at, Fault::Cut))
    });
    let link = Link::start(&server.url, cuts).await;
    let mut streamer = connect(&[&link.url]).await;
    let statistics = scene.arrives(&mut streamer, "many cuts").await;
    assert!(statistics.retries > 0, "{statistics:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_that_is_killed_and_started_again_is_found_again() {
    let scene = Scene::shared();
    for part in [1, 3, 5] {
        let (server, successor) = (scene.server(), scene.server());
        let link = Link::start(&server.url, [(scene.bytes * part / 6, Fault::Hold)]).await;
        let mut streamer = connect(&[&link.url]).await;
        let kill = async {
            link.happened(1).await;
            server.kill();
            // For a while there is none, however often it is asked for.
            link.cut();
            link.asked(2).await;
            link.lead_to(&successor.url);
        };
        let (statistics, ()) = within(join(scene.arrives(&mut streamer, "killed"), kill)).await;
        assert!(statistics.retries > 0, "{statistics:?}");
        assert_eq!(statistics.failovers, 0);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn where_a_server_dies_another_takes_over() {
    let scene = Scene::shared();
    let (server, other) = (scene.server(), scene.server());
    let link = Link::start(&server.url, [(scene.bytes / 3, Fault::Hold)]).await;
    let mut streamer = connect(&[&link.url, &other.url]).await;
    let kill = async {
        link.happened(1).await;
        server.kill();
        link.cut();
    };
    let (statistics, ()) = within(join(scene.arrives(&mut streamer, "killed"), kill)).await;
    assert!(statistics.retries > 0 && statistics.failovers > 0, "{statistics:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn where_a_server_falls_silent_another_takes_over() {
    let scene = Scene::shared();
    let (server, other) = (scene.server(), scene.server());
    let link = Link::start(&server.url, [(scene.bytes / 3, Fault::Hold)]).await;
    let mut streamer = connect(&[&link.url, &other.url]).await;
    let stop = async {
        link.happened(1).await;
        // Its connections stay open, and nothing comes, be it from buffers on the way.
        server.signal("-STOP");
    };
    let (statistics, ()) = within(join(scene.arrives(&mut streamer, "stopped"), stop)).await;
    assert!(statistics.retries > 0 && statistics.failovers > 0, "{statistics:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_that_never_was_does_no_harm() {
    let scene = Scene::shared();
    let server = scene.server();
    let gone = scene.server();
    let nobody = gone.url.clone();
    gone.kill();
    let mut streamer = connect(&[&nobody, &server.url]).await;
    let statistics = scene.arrives(&mut streamer, "one of two").await;
    assert!(statistics.failovers > 0, "{statistics:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn where_nobody_answers_that_is_said() {
    let gone = [Scene::shared().server(), Scene::shared().server()];
    let urls = gone.map(|server| {
        let url = server.url.clone();
        server.kill();
        url
    });
    let channels: Vec<_> = urls.iter().map(|url| channel(url)).collect();
    let connected = within(Streamer::connect(channels, "sample")).await;
    let error = connected.expect_err("there is no server");
    assert!(matches!(&error, StreamError::Status { call: "GetScene", .. }), "{error}");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_came_before_a_client_was_closed_is_not_fetched_again() {
    let scene = Scene::shared();
    let server = scene.server();
    let folder = tempfile::tempdir().expect("a folder");
    let disk = DiskOptions { folder: folder.path().into(), bytes: 64 << 20 };
    let cache = CacheOptions { memory_bytes: 16 << 20, disk: Some(disk) };
    let options = || StreamOptions { cache: cache.clone(), ..StreamOptions::default() };
    // Late: a few requests bring everything side by side, and half a payload is none.
    let link = Link::start(&server.url, [(scene.bytes * 9 / 10, Fault::Hold)]).await;
    let mut streamer = connect_with(&[&link.url], options()).await;
    {
        let stop = CancellationToken::new();
        let mut events = streamer.stream(scene.request.clone(), &stop);
        let end = async {
            link.happened(1).await;
            stop.cancel();
        };
        let consume = async { while let Some(Ok(_)) = events.next().await {} };
        within(join(consume, end)).await;
    }
    streamer.flush().await;
    drop(streamer);
    let mut streamer = connect_with(&[&server.url], options()).await;
    let statistics = scene.arrives(&mut streamer, "again").await;
    assert!(statistics.cache_hits > 0, "{statistics:?}");
    assert!(statistics.bytes_received < scene.bytes * 3 / 4, "{statistics:?} of {}", scene.bytes);
}

/// What becomes of a file; `None` where it is gone.
type Decay = fn(Vec<u8>) -> Option<Vec<u8>>;

/// What may happen to a file: a byte in its middle changes, its second half is lost, it is gone.
fn decay() -> [(&'static str, Decay); 3] {
    let flipped = |mut bytes: Vec<u8>| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0x10;
        Some(bytes)
    };
    let halved = |bytes: Vec<u8>| Some(bytes[..bytes.len() / 2].to_vec());
    [("flipped", flipped), ("halved", halved), ("gone", |_| None)]
}

#[tokio::test(flavor = "multi_thread")]
async fn what_has_rotted_in_a_store_is_had_from_another() {
    let scene = Scene::shared();
    let good = scene.server();
    for (what, happens) in decay() {
        for suffix in [".laz", "0.jpg", ".png"] {
            let what = format!("{suffix} is {what}");
            let rotten = scene.copy(suffix, happens);
            let bad = Served::start(&[rotten.path()]);
            let mut streamer = connect(&[&bad.url, &good.url]).await;
            let counted = scene.arrives(&mut streamer, &what).await;
            assert!(counted.failovers > 0, "{what}: {counted:?}");

            // Alone, it has everything else; what is missing is said.
            let mut streamer = connect(&[&bad.url]).await;
            let (held, counted, faults) = hold_what_comes(&mut streamer, &scene.request).await;
            assert!(!faults.is_empty(), "{what}: {counted:?}");
            let missing = held.difference(&scene.expected);
            let kind = if suffix == ".laz" { "PointNodeId" } else { "ImageId" };
            let right = missing.iter().all(|name| name.starts_with(kind));
            assert!(!missing.is_empty() && right, "{what}: {missing:?}");
        }
    }
}

/// 300 ms to the server and back, and one packet in fifty lost, each way.
#[test]
fn a_slow_network_that_loses_packets() {
    lossy::in_a_network_of_its_own("a_slow_network_that_loses_packets", || {
        let runtime = tokio::runtime::Runtime::new().expect("a runtime");
        runtime.block_on(async {
            let scene = Scene::shared();
            let lossy = lossy::Lossy::start(150, 2);
            let server = Served::start_at(&[&scene.store], &format!("{}:0", lossy::SERVER));
            let url = server.url.replace(lossy::SERVER, lossy::CLIENT);
            let mut streamer = connect(&[&url]).await;
            let statistics = scene.arrives(&mut streamer, "over a lossy network").await;
            println!("{statistics:?}");
            let lost = lossy.stop();
            assert!(lost > 0, "nothing was lost");
        });
    });
}

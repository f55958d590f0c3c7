//! The services as `deploy/compose.yaml` puts them together, as plain processes: an object store, a data
//! server that reads from it, two render replicas that read from that one, and nginx before them all with
//! `deploy/nginx.conf`.

mod gateway;
#[path = "../served/mod.rs"]
mod served;
mod store;
#[path = "../street/mod.rs"]
mod street;
mod visitor;

use std::ffi::OsStr;
use std::future::poll_fn;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use flaneur_proto::v1;
use gateway::Gateway;
use served::Served;
use store::ObjectStore;
use street::SampleStreet;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tonic::body::Body;
use tonic::client::GrpcService;
use tonic::codegen::http;
use tonic::transport::Endpoint;
use v1::scene_service_client::SceneServiceClient;
use visitor::{Talk, Visitor};

/// Steps before and after a replica ends.
const STEPS: u64 = 6;
/// Sessions that are spread over the replicas: that one has them all is as likely as that so many coins
/// fall alike.
const SESSIONS: u32 = 16;

/// All of it.
struct Topology {
    data: Served,
    replicas: [Option<Served>; 2],
    urls: [String; 2],
    gateway: Gateway,
}

impl Topology {
    fn start(store: &ObjectStore) -> Self {
        let url = store.url();
        let arguments = [url.as_str(), "--no-render", "--listen", "127.0.0.1:0"].map(OsStr::new);
        let data = Served::run(store.told(&mut Served::command(arguments)));
        let replicas = [(); 2].map(|()| Served::with([OsStr::new(&data.url)]));
        let urls = [0, 1].map(|index: usize| replicas[index].url.clone());
        let gateway = Gateway::start(&data.url, [&urls[0], &urls[1]]);
        Self { data, replicas: replicas.map(Some), urls, gateway }
    }

    /// Calls in flight of each replica that runs.
    async fn calls(&self) -> [f64; 2] {
        let mut calls = [0.0; 2];
        for ((calls, url), replica) in calls.iter_mut().zip(&self.urls).zip(&self.replicas) {
            if replica.is_none() {
                continue;
            }
            let (_, page) = get(url, "/metrics").await;
            let figure =
                page.lines().find_map(|line| line.strip_prefix("flaneur_requests_in_flight "));
            *calls = figure.expect("it is counted").parse().expect("a number");
        }
        calls
    }

    /// Kills the replica that answers the only walk.
    async fn kill_the_walkers(&mut self) {
        let calls = self.calls().await;
        let index = usize::from(calls[1] > calls[0]);
        assert!(calls[index] > 0.0 && calls[1 - index] == 0.0, "one walks: {calls:?}");
        self.replicas[index].take().expect("it runs").kill();
    }

    /// Starts again what was killed.
    fn restore(&mut self) {
        for (replica, url) in self.replicas.iter_mut().zip(&self.urls) {
            replica.get_or_insert_with(|| {
                let listen = url.trim_start_matches("http://");
                let arguments = [self.data.url.as_str(), "--listen", listen];
                Served::run(&mut Served::command(arguments.map(OsStr::new)))
            });
        }
    }
}

/// Half a metre further down the road with each step.
fn view(step: u64) -> v1::View {
    let (sin, cos) = 35f64.to_radians().sin_cos();
    let way = 0.5 * step as f64;
    let (x, y, z) = (651_487.5 + way * sin, 6_861_042.9 + way * cos, 44.2);
    v1::View {
        eye: Some(v1::Point3 { x, y, z }),
        heading_deg: 35.0,
        pitch_deg: -4.0,
        extent: Some(v1::view::Extent::FovDeg(60.0)),
        width: 192,
        height: 96,
        mode: v1::Mode::Hybrid.into(),
        may_shrink: false,
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn walks_go_on_when_a_replica_ends() {
    let street = SampleStreet::ingested("topology").await;
    let store = ObjectStore::start().await;
    publish(&street.survey, &store);
    let mut topology = Topology::start(&store);
    pages_and_data_come_through_the_gateway(&topology).await;
    sessions_stay_where_they_began(&topology).await;

    let talk = Talk::grpc(&topology.gateway.grpc).await;
    walk_past_the_end_of_a_replica(&mut topology, talk, "a-walk-over-grpc").await;
    topology.restore();
    let talk = Talk::web(&topology.gateway.web);
    walk_past_the_end_of_a_replica(&mut topology, talk, "a-walk-as-the-page").await;
}

/// As the service `ingest` does it.
fn publish(survey: &Path, store: &ObjectStore) {
    let work = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_flaneur"));
    command.arg("ingest").arg(survey).args(["--out", &store.url(), "--work"]).arg(work.path());
    let output = store.told(&mut command).output().expect("the binary");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

async fn walk_past_the_end_of_a_replica(topology: &mut Topology, talk: Talk, session: &str) {
    let mut visitor = Visitor::new(talk, session);
    for step in 1..=STEPS {
        visitor.look(step, view(step), false).await;
    }
    assert_eq!(visitor.beginnings, 1, "nothing happens yet");
    topology.kill_the_walkers().await;
    for step in STEPS + 1..2 * STEPS {
        visitor.look(step, view(step), false).await;
    }
    assert!(visitor.beginnings > 1, "they noticed");
    let frame = visitor.look(2 * STEPS, view(2 * STEPS), true).await;
    assert!(frame.complete && frame.remaining == 0 && frame.fault.is_empty(), "{frame:?}");
    let picture = image::load_from_memory(&frame.image).expect("a picture").into_rgb8();
    assert_eq!(picture.dimensions(), (192, 96));
}

async fn sessions_stay_where_they_began(topology: &Topology) {
    let mut visitors = Vec::new();
    for number in 0..SESSIONS {
        let session = format!("one-of-many-{number:04}");
        let mut visitor = Visitor::new(Talk::web(&topology.gateway.web), &session);
        visitor.look(1, view(1), false).await;
        visitors.push(visitor);
    }
    for step in 2..5 {
        for visitor in &mut visitors {
            visitor.look(step, view(step), false).await;
            assert_eq!(visitor.beginnings, 1, "its replica knows the session");
        }
    }
    let calls = topology.calls().await;
    assert_eq!(calls.iter().sum::<f64>(), f64::from(SESSIONS), "{calls:?}");
    assert!(calls.iter().all(|calls| *calls > 0.0), "both have some: {calls:?}");
    drop(visitors);
    for _ in 0..200 {
        if topology.calls().await == [0.0; 2] {
            return;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    panic!("who goes is noticed");
}

async fn pages_and_data_come_through_the_gateway(topology: &Topology) {
    let gateway = &topology.gateway;
    let (status, page) = get(&gateway.web, "/").await;
    assert!(status == 200 && !page.is_empty(), "{status} {page}");
    assert_eq!(get(&gateway.web, "/metrics").await.0, 404);
    assert_eq!(status_over_http2(&gateway.grpc, "/metrics").await, 404);
    let mut scenes = SceneServiceClient::connect(gateway.grpc.clone()).await.expect("it answers");
    let listed = scenes.list_scenes(v1::ListScenesRequest {}).await.expect("data").into_inner();
    assert_eq!(listed.scenes.len(), 1);
    // The replicas have no data of their own.
    let mut direct =
        SceneServiceClient::connect(topology.urls[0].clone()).await.expect("it answers");
    let refused = direct.list_scenes(v1::ListScenesRequest {}).await.expect_err("no such service");
    assert_eq!(refused.code(), tonic::Code::Unimplemented);
}

/// Status of a page where only gRPC is spoken.
async fn status_over_http2(url: &str, path: &str) -> u16 {
    let mut channel = Endpoint::from_shared(url.to_owned()).expect("a URL").connect_lazy();
    poll_fn(|context| GrpcService::<Body>::poll_ready(&mut channel, context))
        .await
        .expect("it listens");
    let request = http::Request::get(format!("{url}{path}")).body(Body::empty());
    let answer = channel.call(request.expect("a request")).await.expect("it answers");
    answer.status().as_u16()
}

/// Status and body of a page.
async fn get(url: &str, path: &str) -> (u16, String) {
    let address = url.trim_start_matches("http://");
    let mut stream = TcpStream::connect(address).await.expect("it listens");
    let request = format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.expect("it listens");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).await.expect("it answers");
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let status = answer.split(' ').nth(1).and_then(|status| status.parse().ok());
    let (_, body) = answer.split_once("\r\n\r\n").expect("a body");
    (status.expect("a status"), body.to_owned())
}

//! The services on a real port: HTTP/2, gRPC-Web over HTTP/1, metrics, and the end.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use flaneur_proto::v1;
use flaneur_scene::{ImageId, Region};
use object_store::ObjectStore;
use prost::Message;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tonic::Code;
use tonic::transport::Endpoint;
use tonic_health::pb::health_client::HealthClient;
use tonic_health::pb::{HealthCheckRequest, health_check_response::ServingStatus};
use tonic_types::StatusExt;

use super::answers::all;
use super::street::{self, SCENE};
use crate::grpc::{Limits, Offer, ServeError, Server};
use crate::store::Catalog;

use v1::footprint_service_client::FootprintServiceClient;
use v1::panorama_service_client::PanoramaServiceClient;
use v1::render_service_client::RenderServiceClient;
use v1::scene_service_client::SceneServiceClient;

/// A server, until it is dropped.
pub(super) struct Running {
    address: SocketAddr,
    stop: oneshot::Sender<()>,
    task: JoinHandle<Result<(), ServeError>>,
}

impl Running {
    async fn start(limits: Limits) -> Self {
        Self::over(street::street().await, limits).await
    }

    /// Over the store whose objects these are.
    pub(super) async fn over(objects: Arc<dyn ObjectStore>, limits: Limits) -> Self {
        let catalog = Catalog::open([street::store(objects)]).await.expect("memory");
        Self::offering(catalog.into(), limits).await
    }

    async fn offering(offer: Offer, limits: Limits) -> Self {
        let any = "127.0.0.1:0".parse().expect("an address");
        let server = Server::bind(offer, any, limits).await.expect("a free port");
        let address = server.address();
        let (stop, stopped) = oneshot::channel();
        let task = tokio::spawn(server.serve(async {
            let _ = stopped.await;
        }));
        Self { address, stop, task }
    }

    pub(super) fn url(&self) -> String {
        format!("http://{}", self.address)
    }

    /// What it has counted.
    pub(super) async fn metrics(&self) -> String {
        let (_, body) = self.http("GET /metrics HTTP/1.0", b"").await;
        String::from_utf8(body).expect("text")
    }

    /// The answer to an HTTP/1.0 request, head and body.
    async fn http(&self, head: &str, body: &[u8]) -> (String, Vec<u8>) {
        let mut socket = TcpStream::connect(self.address).await.expect("listening");
        let head = format!("{head}\r\nContent-Length: {}\r\n\r\n", body.len());
        socket.write_all(head.as_bytes()).await.expect("sent");
        socket.write_all(body).await.expect("sent");
        let mut answer = Vec::new();
        socket.read_to_end(&mut answer).await.expect("answered");
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").expect("a head");
        let body = answer.split_off(end + 4);
        (String::from_utf8(answer).expect("text").to_ascii_lowercase(), body)
    }
}

/// A server whose pages of those origins may call.
async fn admitting(origins: &[&str]) -> Running {
    let store = street::store(street::street().await);
    let catalog = Catalog::open([store]).await.expect("memory");
    let origins = origins.iter().map(|origin| origin.parse().expect("an origin")).collect();
    Running::offering(Offer { origins, ..catalog.into() }, Limits::default()).await
}

/// What is said to a browser that asks whether a page may call.
async fn preflight(server: &Running) -> String {
    let preflight = "OPTIONS /flaneur.v1.SceneService/GetScene HTTP/1.0\r\n\
        Origin: https://example.org\r\nAccess-Control-Request-Method: POST\r\n\
        Access-Control-Request-Headers: content-type,x-grpc-web";
    server.http(preflight, b"").await.0
}

#[tokio::test]
async fn pages_of_others_may_call_where_someone_has_said_so() {
    let allows = "access-control-allow-origin: ";
    for origins in [&[][..], &["https://example.com", "http://example.org"]] {
        let head = preflight(&admitting(origins).await).await;
        assert!(!head.contains(allows), "{origins:?}: {head}");
    }
    for (origin, said) in [("https://example.org", "https://example.org\r"), ("*", "*\r")] {
        let head = preflight(&admitting(&["https://example.com", origin]).await).await;
        assert!(head.contains(" 200 "), "{head}");
        assert!(head.contains(&[allows, said].concat()), "{head}");
        assert!(head.contains("access-control-allow-headers: *"), "{head}");
    }
}

#[tokio::test]
async fn a_page_in_a_browser_can_call() {
    let server = admitting(&["https://example.org"]).await;
    let call = async |scene: &str| {
        let message = v1::GetSceneRequest { scene: scene.into() }.encode_to_vec();
        let mut frame = vec![0];
        frame.extend((message.len() as u32).to_be_bytes());
        frame.extend(message);
        let request = "POST /flaneur.v1.SceneService/GetScene HTTP/1.0\r\n\
            Origin: https://example.org\r\nContent-Type: application/grpc-web+proto\r\nX-Grpc-Web: 1";
        server.http(request, &frame).await
    };
    let (head, body) = call(SCENE).await;
    assert!(head.contains(" 200 "), "{head}");
    assert!(head.contains("content-type: application/grpc-web"), "{head}");
    assert!(head.contains("access-control-allow-origin: https://example.org"), "{head}");
    assert!(head.contains("access-control-expose-headers: grpc-status"), "{head}");
    let length = u32::from_be_bytes(body[1..5].try_into().expect("four bytes")) as usize;
    let answer = v1::GetSceneResponse::decode(&body[5..5 + length]).expect("a message");
    assert_eq!(answer.scene.expect("there").name, SCENE);
    let trailers = &body[5 + length..];
    assert_eq!(trailers[0], 0x80, "trailers come as the last frame");
    let trailers = String::from_utf8_lossy(&trailers[5..]);
    assert!(trailers.to_ascii_lowercase().contains("grpc-status:0"), "{trailers}");

    let (head, body) = call("nowhere").await;
    let all = format!("{head}{}", String::from_utf8_lossy(&body)).replace(": ", ":");
    assert!(all.contains("grpc-status:5"), "{all}");
}

#[tokio::test]
async fn pages_say_what_this_is_and_metrics_count_calls() {
    let server = Running::start(Limits::default()).await;
    let (head, body) = server.http("GET / HTTP/1.0", b"").await;
    assert!(head.contains(" 200 ") && String::from_utf8_lossy(&body).contains("Flaneur"));
    let (head, _) = server.http("GET /healthz HTTP/1.0", b"").await;
    assert!(head.contains(" 200 "), "{head}");

    let mut client = FootprintServiceClient::connect(server.url()).await.expect("listening");
    let request = v1::StreamFootprintsRequest::new(SCENE, Region::All);
    all(client.stream_footprints(request).await.expect("there").into_inner()).await;
    let request = v1::StreamFootprintsRequest::new("nowhere", Region::All);
    client.stream_footprints(request).await.expect_err("no such scene");
    let mut scenes = SceneServiceClient::connect(server.url()).await.expect("listening");
    scenes.list_scenes(v1::ListScenesRequest {}).await.expect("listed");
    let mut panoramas = PanoramaServiceClient::connect(server.url()).await.expect("listening");
    let image = v1::ImageKey::colour(&ImageId::new("p1", "front").expect("valid"), 0);
    let request = v1::StreamImagesRequest { scene: SCENE.into(), images: vec![image; 500] };
    let mut left = panoramas.stream_images(request).await.expect("there").into_inner();
    left.message().await.expect("no error");

    let text = server.metrics().await;
    assert!(text.contains("flaneur_requests_in_flight 1\n"), "{text}");
    drop(left);
    let path = "/flaneur.v1.FootprintService/StreamFootprints";
    let wanted = [
        format!("flaneur_requests_total{{method=\"{path}\",code=\"OK\"}} 1\n"),
        format!("flaneur_requests_total{{method=\"{path}\",code=\"NOT_FOUND\"}} 1\n"),
        "flaneur_requests_total{method=\"/flaneur.v1.SceneService/ListScenes\",code=\"OK\"} 1\n".into(),
        "flaneur_requests_total{method=\"/flaneur.v1.PanoramaService/StreamImages\",code=\"CANCELLED\"} 1\n".into(),
        "flaneur_requests_in_flight 0\n".into(),
        format!("flaneur_request_seconds_bucket{{method=\"{path}\",le=\"+Inf\"}} 2\n"),
    ];
    // The server hears of a client's leaving a moment later.
    let mut text = String::new();
    for _ in 0..100 {
        text = server.metrics().await;
        if wanted.iter().all(|line| text.contains(line.as_str())) {
            break;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    for line in wanted {
        assert!(text.contains(&line), "{line}{text}");
    }
    let sent = text.lines().find(|line| {
        line.starts_with("flaneur_sent_bytes_total") && line.contains("StreamFootprints")
    });
    let sent: u64 = sent.and_then(|line| line.rsplit(' ').next()?.parse().ok()).expect("a count");
    assert!((1000..100_000).contains(&sent), "{sent}");
}

#[tokio::test]
async fn what_is_not_there_is_not_found() {
    let server = Running::start(Limits::default()).await;
    for path in ["/nothing", "/index.html", "/assets/../healthz", "/made.up/name", "//", "/%ff"] {
        let (head, body) = server.http(&format!("GET {path} HTTP/1.0"), b"").await;
        assert!(head.contains(" 404 "), "{path}: {head}");
        assert!(head.contains("content-type: text/plain"), "{path}: {head}");
        assert!(String::from_utf8_lossy(&body).contains("nothing here"), "{path}");
    }
    // A method is there, but takes calls.
    let method = "/flaneur.v1.SceneService/GetScene";
    for request in [format!("GET {method}"), format!("POST {method}")] {
        let request = format!("{request} HTTP/1.0\r\nContent-Type: application/json");
        let (head, body) = server.http(&request, b"").await;
        assert!(head.contains(" 415 "), "{request}: {head}");
        assert!(String::from_utf8_lossy(&body).contains("application/grpc"), "{request}");
    }
}

#[tokio::test]
async fn a_server_without_pictures_says_who_has_them() {
    let server = Running::start(Limits::default()).await;
    let mut client = RenderServiceClient::connect(server.url()).await.expect("listening");
    let request = v1::RenderFrameRequest { scene: SCENE.into(), ..Default::default() };
    let mut statuses = vec![client.render_frame(request).await.expect_err("no pictures")];
    let request = v1::WatchRequest::default();
    statuses.push(client.watch(request).await.expect_err("no pictures"));
    let request = tokio_stream::iter([v1::ViewUpdate::default()]);
    statuses.push(client.navigate(request).await.expect_err("no pictures"));
    statuses.push(client.update_view(v1::UpdateViewRequest::default()).await.expect_err("none"));
    statuses.push(client.pick(v1::PickRequest::default()).await.expect_err("no pictures"));
    for status in statuses {
        assert_eq!(status.code(), Code::Unimplemented, "{status}");
        assert!(status.message().contains("--no-render"), "{status}");
        assert!(status.message().contains("flaneur serve http://"), "{status}");
    }
}

#[tokio::test]
async fn unknown_methods_do_not_become_labels() {
    let server = Running::start(Limits::default()).await;
    let call = "POST /made.up/name HTTP/1.0\r\nContent-Type: application/grpc-web+proto";
    let (head, _) = server.http(call, &[0; 5]).await;
    assert!(head.contains("grpc-status: 12"), "{head}");
    let (_, body) = server.http("GET /metrics HTTP/1.0", b"").await;
    let metrics = String::from_utf8_lossy(&body);
    assert!(metrics.contains("method=\"unknown\",code=\"UNIMPLEMENTED\""), "{metrics}");
    assert!(!metrics.contains("made.up"), "{metrics}");
}

#[tokio::test]
async fn too_many_calls_are_refused() {
    let server = Running::start(Limits { calls: 1, ..Limits::default() }).await;
    let mut client = PanoramaServiceClient::connect(server.url()).await.expect("listening");
    let image = v1::ImageKey::colour(&ImageId::new("p1", "front").expect("valid"), 0);
    let request = v1::StreamImagesRequest { scene: SCENE.into(), images: vec![image; 100] };
    let first = client.stream_images(request).await.expect("there").into_inner();
    let request = v1::StreamPanoramasRequest::new(SCENE, Region::All);
    let status = client.stream_panoramas(request).await.expect_err("one too many");
    assert_eq!(status.code(), Code::ResourceExhausted, "{status}");
    let hint = status.get_details_retry_info().and_then(|hint| hint.retry_delay);
    assert!(hint.is_some_and(|delay| delay < Duration::from_secs(5)), "{status}");
    assert_eq!(all(first).await.len(), 3900, "the first goes on");
}

#[tokio::test]
async fn a_stop_lets_calls_in_flight_end_and_takes_no_more() {
    let server = Running::start(Limits::default()).await;
    let endpoint = Endpoint::new(server.url()).expect("a URL");
    let mut health = HealthClient::new(endpoint.connect().await.expect("listening"));
    let service = "flaneur.v1.PointService".to_owned();
    let answer = health.check(HealthCheckRequest { service }).await.expect("known").into_inner();
    assert_eq!(answer.status(), ServingStatus::Serving);
    let mut watch = health.watch(HealthCheckRequest::default()).await.expect("known").into_inner();
    let first = watch.message().await.expect("no error").expect("a status");
    assert_eq!(first.status(), ServingStatus::Serving);

    let mut client = PanoramaServiceClient::connect(server.url()).await.expect("listening");
    let image = v1::ImageKey::colour(&ImageId::new("p1", "front").expect("valid"), 0);
    let request = v1::StreamImagesRequest { scene: SCENE.into(), images: vec![image; 100] };
    let mut stream = client.stream_images(request).await.expect("there").into_inner();
    stream.message().await.expect("no error").expect("more to come");

    server.stop.send(()).expect("running");
    let told = watch.message().await.expect("no error").expect("a status");
    assert_eq!(told.status(), ServingStatus::NotServing);
    // The port closes, then what is under way ends.
    let mut refused = false;
    for _ in 0..100 {
        refused = TcpStream::connect(server.address).await.is_err();
        if refused {
            break;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    assert!(refused, "no new connection is taken");
    assert_eq!(all(stream).await.len(), 3899);
    drop((watch, health, client));
    server.task.await.expect("no panic").expect("a good end");
}

//! Over a real connection: who drops a stream, or goes away, is worked for no longer.

use std::sync::Arc;
use std::time::Duration;

use flaneur_proto::v1;
use flaneur_scene::{ImageId, NodeKey};
use tonic::Code;
use tonic::transport::{Channel, Endpoint};

use super::network::Running;
use super::street::{self, SCENE};
use super::watched::{Reads, Watched};
use crate::grpc::Limits;

use v1::panorama_service_client::PanoramaServiceClient;
use v1::point_service_client::PointServiceClient;
use v1::scene_service_client::SceneServiceClient;

async fn start() -> (Running, Arc<Reads>, Channel) {
    let (store, reads) = Watched::over(street::street().await);
    let server = Running::over(store, Limits::default()).await;
    let endpoint = Endpoint::new(server.url()).expect("a URL");
    let channel = endpoint.connect().await.expect("listening");
    (server, reads, channel)
}

fn many_images() -> v1::StreamImagesRequest {
    let key = v1::ImageKey::colour(&ImageId::new("p1", "front").expect("valid"), 0);
    v1::StreamImagesRequest { scene: SCENE.into(), images: vec![key; 4096] }
}

/// Waits until it is so; the server hears of a client's leaving a moment later.
async fn soon(what: &str, mut is_so: impl AsyncFnMut() -> bool) {
    for _ in 0..250 {
        if is_so().await {
            return;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    panic!("never happened: {what}");
}

/// Asserts that nobody waits for a read any more, and none begins; that all calls have ended,
/// one of them because its client left.
async fn assert_nothing_goes_on(server: &Running, reads: &Reads) {
    let cancelled = "code=\"CANCELLED\"} 1\n";
    soon("all calls end", async || {
        let metrics = server.metrics().await;
        metrics.contains("flaneur_requests_in_flight 0\n") && metrics.contains(cancelled)
    })
    .await;
    assert_eq!(reads.under_way(), 0, "a call that has ended waits for no read");
    let begun = reads.begun();
    assert_eq!(reads.settled().await, begun, "and begins none");
}

#[tokio::test]
async fn a_dropped_stream_ends_the_reads_it_waits_for() {
    let (server, reads, channel) = start().await;
    let mut client = PanoramaServiceClient::new(channel.clone());
    let mut stream = client.stream_images(many_images()).await.expect("there").into_inner();
    stream.message().await.expect("no error").expect("more to come");
    reads.close();
    let taking = async { while let Ok(Some(_)) = stream.message().await {} };
    let waiting = soon("reads are under way", async || reads.under_way() > 0);
    tokio::select! {
        () = taking => panic!("the store gives nothing"),
        () = waiting => {}
    }
    drop(stream);
    assert_nothing_goes_on(&server, &reads).await;
    drop(channel);
}

#[tokio::test]
async fn a_dropped_stream_that_nobody_read_is_read_ahead_for_no_longer() {
    let (server, reads, channel) = start().await;
    let mut client = PanoramaServiceClient::new(channel.clone());
    let mut stream = client.stream_images(many_images()).await.expect("there").into_inner();
    stream.message().await.expect("no error").expect("more to come");
    // The client's window is full now.
    reads.settled().await;
    drop(stream);
    assert_nothing_goes_on(&server, &reads).await;
    drop(channel);
}

#[tokio::test]
async fn a_client_that_goes_away_ends_all_its_calls() {
    let (server, reads, channel) = start().await;
    let mut client = PanoramaServiceClient::new(channel);
    let mut stream = client.stream_images(many_images()).await.expect("there").into_inner();
    stream.message().await.expect("no error").expect("more to come");
    drop((stream, client));
    assert_nothing_goes_on(&server, &reads).await;
}

#[tokio::test]
async fn a_call_dropped_before_its_answer_ends_the_reads_it_waits_for() {
    let (server, reads, channel) = start().await;
    // The manifest is known; the hierarchy is not.
    let mut scenes = SceneServiceClient::new(channel.clone());
    let request = v1::GetSceneRequest { scene: SCENE.into() };
    scenes.get_scene(request).await.expect("there");
    reads.close();
    let mut client = PointServiceClient::new(channel.clone());
    let request = v1::StreamChunksRequest {
        scene: SCENE.into(),
        source: "air".into(),
        nodes: vec![NodeKey::ROOT.into()],
    };
    let waiting = soon("a read is under way", async || reads.under_way() > 0);
    tokio::select! {
        _ = client.stream_chunks(request) => panic!("the store gives nothing"),
        () = waiting => {}
    }
    assert_nothing_goes_on(&server, &reads).await;
    drop(channel);
}

#[tokio::test]
async fn who_takes_nothing_for_long_is_disconnected() {
    let limits = Limits { patience: Duration::from_millis(300), ..Limits::default() };
    let server = Running::over(street::street().await, limits).await;
    let endpoint = Endpoint::new(server.url()).expect("a URL");
    let mut client = PanoramaServiceClient::new(endpoint.connect().await.expect("listening"));
    let mut stream = client.stream_images(many_images()).await.expect("there").into_inner();
    // As slow as is allowed.
    for _ in 0..10 {
        stream.message().await.expect("no error").expect("more to come");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    soon("the call ends", async || {
        server.metrics().await.contains("flaneur_requests_in_flight 0\n")
    })
    .await;
    let taken = async {
        while stream.message().await?.is_some() {}
        Ok::<_, tonic::Status>(())
    };
    taken.await.expect_err("it did not end well");
}

#[tokio::test]
async fn more_connections_than_are_taken_are_closed_and_make_room_when_they_end() {
    let server =
        Running::over(street::street().await, Limits { connections: 2, ..Limits::default() }).await;
    let endpoint = Endpoint::new(server.url()).expect("a URL");
    let ask = async |channel: &Channel| {
        let request = v1::GetSceneRequest { scene: SCENE.into() };
        SceneServiceClient::new(channel.clone()).get_scene(request).await
    };
    let first = endpoint.connect().await.expect("listening");
    let second = endpoint.connect().await.expect("listening");
    for channel in [&first, &second] {
        ask(channel).await.expect("there");
    }
    let third = endpoint.connect_lazy();
    ask(&third).await.expect_err("closed");
    drop(first);
    soon("there is room", async || ask(&third).await.is_ok()).await;
}

#[tokio::test]
async fn a_deadline_ends_a_call_whose_client_takes_nothing() {
    let store = street::street().await;
    let server = Running::over(store.clone(), Limits::default()).await;
    let endpoint = Endpoint::new(server.url()).expect("a URL");
    let mut client = PanoramaServiceClient::new(endpoint.connect().await.expect("listening"));
    // What the services keep of the store, they keep from now on.
    let few =
        v1::StreamImagesRequest { images: vec![many_images().images[0].clone()], ..many_images() };
    let mut stream = client.stream_images(few).await.expect("there").into_inner();
    while stream.message().await.expect("no error").is_some() {}
    drop(stream);
    soon("the call ends", async || {
        server.metrics().await.contains("flaneur_requests_in_flight 0\n")
    })
    .await;
    let kept = Arc::strong_count(&store);

    let mut request = tonic::Request::new(many_images());
    // The header alone: tonic's client would otherwise end the stream by itself.
    request.metadata_mut().insert("grpc-timeout", "700m".parse().expect("ASCII"));
    let mut stream = client.stream_images(request).await.expect("in time").into_inner();
    assert!(Arc::strong_count(&store) > kept, "the stream reads from the store");
    soon("it does no more", async || Arc::strong_count(&store) == kept).await;
    // Once the client takes what was on its way, it hears why.
    let status = loop {
        match stream.message().await {
            Ok(Some(_)) => {}
            Ok(None) => panic!("ten gigabytes in less than a second"),
            Err(status) => break status,
        }
    };
    assert_eq!(status.code(), Code::DeadlineExceeded, "{status}");
}

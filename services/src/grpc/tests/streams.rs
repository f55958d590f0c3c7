//! Streams are pulled: who stops reading, goes away or runs out of time stops the work.

use std::sync::Arc;
use std::time::Duration;

use flaneur_proto::v1;
use flaneur_scene::ImageId;
use object_store::ObjectStore;
use object_store::throttle::{ThrottleConfig, ThrottledStore};
use tonic::transport::Channel;
use tonic::{Code, Request, Streaming};

use super::street::{self, SCENE};
use super::watched::Watched;
use crate::grpc::in_process;
use crate::store::Catalog;

use v1::panorama_service_client::PanoramaServiceClient;

async fn serve(objects: Arc<dyn ObjectStore>) -> Channel {
    let catalog = Catalog::open([street::store(objects)]).await.expect("memory");
    in_process(catalog).await.expect("services")
}

/// 4096 times 2.5 MB: far more than all buffers between store and client hold.
fn ten_gigabytes() -> v1::StreamImagesRequest {
    let key = v1::ImageKey::colour(&ImageId::new("p1", "front").expect("valid"), 0);
    v1::StreamImagesRequest { scene: SCENE.into(), images: vec![key; 4096] }
}

async fn next<M>(stream: &mut Streaming<M>) -> M {
    stream.message().await.expect("no error").expect("more to come")
}

#[tokio::test]
async fn who_does_not_read_stops_the_reading_and_who_goes_away_ends_it() {
    let (store, reads) = Watched::over(street::street().await);
    let mut client = PanoramaServiceClient::new(serve(store).await);
    let mut stream = client.stream_images(ten_gigabytes()).await.expect("there").into_inner();
    let before = reads.begun();
    next(&mut stream).await;
    // 16 MiB of window, the pipe, a few images ahead: some ten images, not thousands.
    let waiting = reads.settled().await;
    assert!(waiting - before < 30, "{} reads for one part taken", waiting - before);
    // Taking more lets more be read: it was the client that held the server back.
    for _ in 0..60 {
        next(&mut stream).await;
    }
    let after = reads.settled().await;
    assert!(after > waiting, "{after} reads after 61 parts, {waiting} after one");
    assert!(after - waiting < 60, "{} reads for 60 parts", after - waiting);
    drop(stream);
    let gone = reads.settled().await;
    assert!(gone - after < 30, "{} reads after the client went away", gone - after);
}

#[tokio::test]
async fn a_deadline_ends_the_stream_in_its_middle() {
    let slow = ThrottleConfig {
        wait_get_per_call: Duration::from_millis(20),
        ..ThrottleConfig::default()
    };
    let throttled = Arc::new(ThrottledStore::new(street::street().await, slow));
    let (store, reads) = Watched::over(throttled);
    let mut client = PanoramaServiceClient::new(serve(store).await);
    let mut request = Request::new(ten_gigabytes());
    // The header alone: tonic's client would otherwise end the stream by itself.
    request.metadata_mut().insert("grpc-timeout", "1500m".parse().expect("ASCII"));
    let mut stream = client.stream_images(request).await.expect("in time").into_inner();
    let mut parts = 0;
    let status = loop {
        match stream.message().await {
            Ok(Some(_)) => parts += 1,
            Ok(None) => panic!("ten gigabytes in a second and a half"),
            Err(status) => break status,
        }
    };
    assert_eq!(status.code(), Code::DeadlineExceeded, "{status}");
    assert!(parts > 0, "it had begun");
    let after = reads.settled().await;
    assert_eq!(reads.settled().await, after, "nothing is read after the deadline");
}

#[tokio::test]
async fn a_deadline_that_is_no_duration_is_refused() {
    let mut client = PanoramaServiceClient::new(serve(street::street().await).await);
    let mut request = Request::new(ten_gigabytes());
    request.metadata_mut().insert("grpc-timeout", "soon".parse().expect("ASCII"));
    let status = client.stream_images(request).await.expect_err("no duration");
    assert_eq!(status.code(), Code::InvalidArgument, "{status}");
    assert!(status.message().contains("grpc-timeout"), "{status}");
}

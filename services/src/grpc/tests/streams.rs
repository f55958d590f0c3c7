//! Streams are pulled: who stops reading, goes away or runs out of time stops the work.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use flaneur_proto::v1;
use flaneur_scene::ImageId;
use futures::stream::BoxStream;
use object_store::path::Path;
use object_store::throttle::{ThrottleConfig, ThrottledStore};
use object_store::{
    CopyOptions, GetOptions, GetResult, ListResult, MultipartUpload, ObjectMeta, ObjectStore,
    PutMultipartOptions, PutOptions, PutPayload, PutResult, Result,
};
use tonic::transport::Channel;
use tonic::{Code, Request, Streaming};

use super::street::{self, SCENE};
use crate::grpc::in_process;
use crate::store::Catalog;

use v1::panorama_service_client::PanoramaServiceClient;

/// A store that counts what is read from it.
#[derive(Debug)]
struct Counting {
    inner: Arc<dyn ObjectStore>,
    reads: Arc<AtomicUsize>,
}

impl fmt::Display for Counting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "counting {}", self.inner)
    }
}

#[tonic::async_trait]
impl ObjectStore for Counting {
    async fn get_opts(&self, path: &Path, options: GetOptions) -> Result<GetResult> {
        self.reads.fetch_add(1, Ordering::SeqCst);
        self.inner.get_opts(path, options).await
    }

    async fn put_opts(&self, path: &Path, payload: PutPayload, o: PutOptions) -> Result<PutResult> {
        self.inner.put_opts(path, payload, o).await
    }

    async fn put_multipart_opts(
        &self,
        path: &Path,
        options: PutMultipartOptions,
    ) -> Result<Box<dyn MultipartUpload>> {
        self.inner.put_multipart_opts(path, options).await
    }

    fn delete_stream(
        &self,
        paths: BoxStream<'static, Result<Path>>,
    ) -> BoxStream<'static, Result<Path>> {
        self.inner.delete_stream(paths)
    }

    fn list(&self, prefix: Option<&Path>) -> BoxStream<'static, Result<ObjectMeta>> {
        self.inner.list(prefix)
    }

    async fn list_with_delimiter(&self, prefix: Option<&Path>) -> Result<ListResult> {
        self.inner.list_with_delimiter(prefix).await
    }

    async fn copy_opts(&self, from: &Path, to: &Path, options: CopyOptions) -> Result<()> {
        self.inner.copy_opts(from, to, options).await
    }
}

async fn serve(objects: Arc<dyn ObjectStore>) -> Channel {
    let catalog = Catalog::open([street::store(objects)]).await.expect("memory");
    in_process(catalog).await.expect("services")
}

/// 4096 times 2.5 MB: far more than all buffers between store and client hold.
fn ten_gigabytes() -> v1::StreamImagesRequest {
    let key = v1::ImageKey::colour(&ImageId::new("p1", "front").expect("valid"), 0);
    v1::StreamImagesRequest { scene: SCENE.into(), images: vec![key; 4096] }
}

/// Waits until the count has not moved for a while, and gives it.
async fn settled(reads: &AtomicUsize) -> usize {
    let mut last = reads.load(Ordering::SeqCst);
    let mut quiet = 0;
    while quiet < 10 {
        tokio::time::sleep(Duration::from_millis(20)).await;
        let now = reads.load(Ordering::SeqCst);
        quiet = if now == last { quiet + 1 } else { 0 };
        last = now;
    }
    last
}

async fn next<M>(stream: &mut Streaming<M>) -> M {
    stream.message().await.expect("no error").expect("more to come")
}

#[tokio::test]
async fn who_does_not_read_stops_the_reading_and_who_goes_away_ends_it() {
    let reads = Arc::new(AtomicUsize::new(0));
    let counting = Counting { inner: street::street().await, reads: reads.clone() };
    let mut client = PanoramaServiceClient::new(serve(Arc::new(counting)).await);
    let mut stream = client.stream_images(ten_gigabytes()).await.expect("there").into_inner();
    let before = reads.load(Ordering::SeqCst);
    next(&mut stream).await;
    // 16 MiB of window, the pipe, a few images ahead: some ten images, not thousands.
    let waiting = settled(&reads).await;
    assert!(waiting - before < 30, "{} reads for one part taken", waiting - before);
    // Taking more lets more be read: it was the client that held the server back.
    for _ in 0..60 {
        next(&mut stream).await;
    }
    let after = settled(&reads).await;
    assert!(after > waiting, "{after} reads after 61 parts, {waiting} after one");
    assert!(after - waiting < 60, "{} reads for 60 parts", after - waiting);
    drop(stream);
    let gone = settled(&reads).await;
    assert!(gone - after < 30, "{} reads after the client went away", gone - after);
}

#[tokio::test]
async fn a_deadline_ends_the_stream_in_its_middle() {
    let slow = ThrottleConfig {
        wait_get_per_call: Duration::from_millis(20),
        ..ThrottleConfig::default()
    };
    let reads = Arc::new(AtomicUsize::new(0));
    let throttled = Arc::new(ThrottledStore::new(street::street().await, slow));
    let counting = Counting { inner: throttled, reads: reads.clone() };
    let mut client = PanoramaServiceClient::new(serve(Arc::new(counting)).await);
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
    let after = settled(&reads).await;
    assert_eq!(settled(&reads).await, after, "nothing is read after the deadline");
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

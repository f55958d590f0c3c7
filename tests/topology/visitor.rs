//! Someone who walks, over gRPC or as the page does it, and who does not give up when a server does.

use std::time::Duration;

use flaneur_proto::v1;
use hyper_util::client::legacy::Client;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::TokioExecutor;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::body::Body;
use tonic::metadata::AsciiMetadataValue;
use tonic::transport::Channel;
use tonic::{Request, Status, Streaming};
use tonic_web::{GrpcWebCall, GrpcWebClientService};
use v1::render_service_client::RenderServiceClient;

/// How long a frame may take, whatever happens meanwhile.
const PATIENCE: Duration = Duration::from_secs(60);

type Web = GrpcWebClientService<Client<HttpConnector, GrpcWebCall<Body>>>;

/// How one talks to the service.
pub(crate) enum Talk {
    /// Navigate: one call both ways.
    Grpc(RenderServiceClient<Channel>),
    /// Watch and UpdateView, over HTTP/1.1.
    Web(Box<RenderServiceClient<Web>>),
}

/// A visitor of the scene `sample`.
pub(crate) struct Visitor {
    talk: Talk,
    session: String,
    frames: Option<Frames>,
    /// How often they had to begin again.
    pub(crate) beginnings: u32,
}

/// A call under way.
struct Frames {
    frames: Streaming<v1::Frame>,
    /// What is said further in the same call.
    updates: Option<mpsc::Sender<v1::ViewUpdate>>,
}

impl Talk {
    pub(crate) async fn grpc(url: &str) -> Self {
        Self::Grpc(RenderServiceClient::connect(url.to_owned()).await.expect("it answers"))
    }

    pub(crate) fn web(url: &str) -> Self {
        let client = Client::builder(TokioExecutor::new()).build_http();
        let origin = url.parse().expect("a URL");
        let client = RenderServiceClient::with_origin(GrpcWebClientService::new(client), origin);
        Self::Web(Box::new(client))
    }
}

impl Visitor {
    pub(crate) fn new(talk: Talk, session: &str) -> Self {
        Self { talk, session: session.to_owned(), frames: None, beginnings: 0 }
    }

    /// The first frame of view `sequence`, or its last, whatever it takes to get it. A frame that
    /// comes answers what was asked.
    pub(crate) async fn look(&mut self, sequence: u64, view: v1::View, last: bool) -> v1::Frame {
        let update = v1::ViewUpdate {
            scene: "sample".to_owned(),
            sequence,
            view: Some(view),
            quality: None,
            received_frame: 0,
        };
        let frame = tokio::time::timeout(PATIENCE, async {
            loop {
                match self.attempt(&update, last).await {
                    Ok(frame) => return frame,
                    Err(status) => {
                        self.frames = None;
                        eprintln!("{}: watches again after {status}", self.session);
                        tokio::time::sleep(Duration::from_millis(50)).await;
                    }
                }
            }
        });
        let frame = frame.await.expect("a frame comes");
        assert_eq!(frame.view, Some(view), "the frame says what it shows");
        frame
    }

    async fn attempt(&mut self, update: &v1::ViewUpdate, last: bool) -> Result<v1::Frame, Status> {
        if self.frames.is_some() {
            self.say(update.clone()).await?;
        } else {
            self.frames = Some(self.begin(update.clone()).await?);
            self.beginnings += 1;
        }
        let ended = || Status::unavailable("the frames have ended");
        let frames = &mut self.frames.as_mut().ok_or_else(ended)?.frames;
        loop {
            let frame = frames.message().await?.ok_or_else(ended)?;
            assert!(frame.sequence <= update.sequence, "nobody asked for {}", frame.sequence);
            if frame.sequence == update.sequence && (frame.r#final || !last) {
                return Ok(frame);
            }
        }
    }

    async fn begin(&mut self, update: v1::ViewUpdate) -> Result<Frames, Status> {
        let session = self.session.clone();
        match &mut self.talk {
            Talk::Grpc(client) => {
                let (sender, receiver) = mpsc::channel(8);
                drop(sender.send(update).await);
                let request = named(ReceiverStream::new(receiver), &session);
                let frames = client.navigate(request).await?.into_inner();
                Ok(Frames { frames, updates: Some(sender) })
            }
            Talk::Web(client) => {
                let name = session.clone();
                let update = Some(update);
                let request = named(v1::WatchRequest { session, update }, &name);
                let frames = client.watch(request).await?.into_inner();
                Ok(Frames { frames, updates: None })
            }
        }
    }

    async fn say(&mut self, update: v1::ViewUpdate) -> Result<(), Status> {
        let gone = || Status::unavailable("the call has ended");
        let updates = self.frames.as_ref().and_then(|frames| frames.updates.clone());
        match (&mut self.talk, updates) {
            (_, Some(updates)) => updates.send(update).await.map_err(|_| gone()),
            (Talk::Grpc(_), None) => Err(gone()),
            (Talk::Web(client), None) => {
                let (session, update) = (self.session.clone(), Some(update));
                let name = session.clone();
                let request = named(v1::UpdateViewRequest { session, update }, &name);
                client.update_view(request).await.map(drop)
            }
        }
    }
}

/// A request that says to proxies which session it is of.
fn named<T>(message: T, session: &str) -> Request<T> {
    let mut request = Request::new(message);
    let session = AsciiMetadataValue::try_from(session).expect("letters and digits");
    request.metadata_mut().insert("flaneur-session", session);
    request
}

//! The calls.

use std::sync::Arc;
use std::time::Duration;

use flaneur_proto::{FieldError, v1};
use flaneur_renderer::Gpu;
use flaneur_streamer::Servers;
use glam::DVec2;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use tokio::time::Instant;
use tokio_stream::wrappers::ReceiverStream;
use tokio_util::sync::CancellationToken;
use tonic::metadata::MetadataMap;
use tonic::{Request, Response, Status, Streaming};

use super::inputs::{Inputs, Refusal, overtake};
use super::scenes::Scenes;
use super::sessions::{Sessions, check_name};
use super::still::{self, Still};
use super::wanted::{Wanted, Wish};
use super::{RenderOptions, pick, refuse, session};
use crate::grpc::status;

/// The metadata in which a call names its session.
const SESSION: &str = "flaneur-session";
/// How long the first view of a walk may take to come.
const FIRST_VIEW: Duration = Duration::from_secs(10);
/// Most picks at a time; more wait.
const PICKS: usize = 4;

/// The render service. Clones are the same service.
#[derive(Clone)]
pub struct Rendering {
    options: Arc<RenderOptions>,
    /// What there is to render with, or why there is nothing.
    scenes: Result<Arc<Scenes>, Arc<str>>,
    sessions: Arc<Sessions>,
    /// One for each session, and each picture that is waited for.
    places: Arc<Semaphore>,
    /// One for each pick: who asks a lot at once must not keep those waiting who walk.
    picks: Arc<Semaphore>,
    adapter: Option<Arc<str>>,
    /// Cancelled when the server stops.
    stopping: CancellationToken,
}

impl Rendering {
    /// Renders the scenes that `servers` have. Where the machine has no driver every call is answered
    /// UNAVAILABLE, with the remedy. Takes a moment: the driver is opened. To be called in a runtime.
    pub fn new(servers: impl Into<Servers>, options: RenderOptions) -> Self {
        let options = Arc::new(options);
        let gpu = Gpu::new();
        let adapter = gpu.as_ref().ok().map(|gpu| Arc::from(gpu.adapter_name()));
        let scenes =
            gpu.map(|gpu| Arc::new(Scenes::new(servers.into(), gpu, Arc::clone(&options))));
        let scenes = scenes.map_err(|error| Arc::from(error.to_string()));
        let places = Arc::new(Semaphore::new(options.sessions));
        let picks = Arc::new(Semaphore::new(PICKS));
        let (sessions, stopping) = (Arc::default(), CancellationToken::new());
        Self { options, scenes, sessions, places, picks, adapter, stopping }
    }

    /// Name of the adapter that renders, or why none does.
    pub fn adapter(&self) -> Result<&str, &str> {
        match (&self.scenes, &self.adapter) {
            (Err(reason), _) => Err(reason),
            (Ok(_), adapter) => Ok(adapter.as_deref().unwrap_or_default()),
        }
    }

    /// Ends all sessions, and begins none any more: their clients watch another server.
    pub(crate) fn stop(&self) {
        self.stopping.cancel();
    }

    fn scenes(&self) -> Result<&Arc<Scenes>, Status> {
        self.scenes.as_ref().map_err(|reason| {
            Status::unavailable(format!(
                "this server cannot render: {reason}; or ask another server"
            ))
        })
    }

    /// Whether a call is of a session that looks at `scene` here.
    fn walks(&self, metadata: &MetadataMap, scene: &str) -> bool {
        let name = metadata.get(SESSION).and_then(|name| name.to_str().ok());
        let inputs = name.and_then(|name| self.sessions.inputs(name));
        inputs.is_some_and(|inputs| inputs.scene() == scene)
    }

    fn place(&self) -> Result<OwnedSemaphorePermit, Status> {
        let place = Arc::clone(&self.places).try_acquire_owned();
        place.map_err(|_| refuse::busy("sessions"))
    }

    /// The frames of a session, until `ending` says why there are no more. The task behind them ends
    /// when nobody takes them.
    async fn begin(
        &self,
        place: Arc<OwnedSemaphorePermit>,
        inputs: Arc<Inputs>,
        ending: impl Future<Output = Status> + Send + 'static,
    ) -> Result<Response<FrameStream>, Status> {
        let scene = self.scenes()?.open(inputs.scene()).await?;
        let (frames, receiver) = mpsc::channel(1);
        let (options, stopping) = (Arc::clone(&self.options), self.stopping.clone());
        tokio::spawn(async move {
            let status = tokio::select! {
                outcome = session::run(scene, inputs, options, frames.clone()) => outcome.err(),
                status = ending => Some(status),
                () = stopping.cancelled() => {
                    Some(Status::unavailable("the server is stopping"))
                }
            };
            if let Some(status) = status {
                // Nobody may listen any more.
                drop(frames.send(Err(status)).await);
            }
            drop(place);
        });
        Ok(Response::new(ReceiverStream::new(receiver)))
    }
}

/// Hears what a client says until it says no more; ends with what was wrong. Of what comes too fast
/// the latest counts, once it may.
async fn listen(
    mut updates: Streaming<v1::ViewUpdate>,
    inputs: Arc<Inputs>,
    options: Arc<RenderOptions>,
) -> Status {
    let mut says_more = true;
    let mut early: Option<(v1::ViewUpdate, Instant)> = None;
    while says_more || early.is_some() {
        let at = early.as_ref().map_or_else(Instant::now, |&(_, at)| at);
        let update = tokio::select! {
            heard = updates.message(), if says_more => match (heard, &mut early) {
                (Ok(Some(update)), None) => update,
                (Ok(Some(update)), Some((earlier, _))) => {
                    overtake(earlier, update);
                    continue;
                }
                (Ok(None), _) => {
                    says_more = false;
                    continue;
                }
                (Err(status), _) => return status,
            },
            () = tokio::time::sleep_until(at), if early.is_some() => match early.take() {
                Some((update, _)) => update,
                None => continue,
            },
        };
        match inputs.update(&update) {
            Ok(()) => {}
            Err(Refusal::TooFast(wait)) => early = Some((update, Instant::now() + wait)),
            Err(refusal @ Refusal::Bad(_)) => return refusal.status(&options),
        }
    }
    inputs.close();
    std::future::pending().await
}

/// Frames as they are made.
type FrameStream = ReceiverStream<Result<v1::Frame, Status>>;

#[tonic::async_trait]
impl v1::render_service_server::RenderService for Rendering {
    async fn render_frame(
        &self,
        request: Request<v1::RenderFrameRequest>,
    ) -> Result<Response<v1::Frame>, Status> {
        let request = request.into_inner();
        let view = view_of(request.view).and_then(|view| Wanted::new(1, view, &self.options));
        let wanted = view.map_err(|e| status::invalid(&e.within("view")))?;
        let wish = Wish::new(request.quality.as_ref());
        let wish = wish.map_err(|e| status::invalid(&e.within("quality")))?;
        let scenes = self.scenes()?;
        let _place = self.place()?;
        let scene = scenes.open(&request.scene).await?;
        still::frame(scene, wanted, wish, &self.options).await.map(Response::new)
    }

    type NavigateStream = FrameStream;

    async fn navigate(
        &self,
        request: Request<Streaming<v1::ViewUpdate>>,
    ) -> Result<Response<FrameStream>, Status> {
        self.scenes()?;
        let mut updates = request.into_inner();
        let first = tokio::time::timeout(FIRST_VIEW, updates.message()).await;
        let first = first.map_err(|_| Status::deadline_exceeded("no view was sent"))??;
        let first = first.ok_or_else(|| Status::invalid_argument("no view was sent"))?;
        let inputs = Inputs::begin(first, &self.options).map_err(|e| status::invalid(&e))?;
        // Who has not said what to show takes nobody's place.
        let place = Arc::new(self.place()?);
        let inputs = Arc::new(inputs);
        let ending = listen(updates, Arc::clone(&inputs), Arc::clone(&self.options));
        self.begin(place, inputs, ending).await
    }

    type WatchStream = FrameStream;

    async fn watch(
        &self,
        request: Request<v1::WatchRequest>,
    ) -> Result<Response<FrameStream>, Status> {
        let v1::WatchRequest { session, update } = request.into_inner();
        check_name(&session).map_err(|e| status::invalid(&e))?;
        let update = update.ok_or_else(|| FieldError::new("update", "is absent"));
        let inputs = update
            .and_then(|update| Inputs::begin(update, &self.options).map_err(|e| e.within("update")))
            .map_err(|e| status::invalid(&e))?;
        let inputs = Arc::new(inputs);
        self.scenes()?;
        let watched = self.sessions.watch(session, Arc::clone(&inputs), || self.place())?;
        let place = Arc::clone(&watched.place);
        self.begin(place, inputs, async move {
            // The session is known for as long as its frames are.
            watched.superseded.cancelled().await;
            Status::aborted("the session is watched by another call")
        })
        .await
    }

    async fn update_view(
        &self,
        request: Request<v1::UpdateViewRequest>,
    ) -> Result<Response<v1::UpdateViewResponse>, Status> {
        let v1::UpdateViewRequest { session, update } = request.into_inner();
        let inputs = self.sessions.inputs(&session);
        let inputs = inputs.ok_or_else(|| {
            Status::not_found("the session has ended, or is another server's: begin another")
        })?;
        let update = update.ok_or_else(|| FieldError::new("update", "is absent"));
        let update = update.map_err(|e| status::invalid(&e))?;
        inputs.update(&update).map_err(|refusal| refusal.within("update").status(&self.options))?;
        Ok(Response::new(v1::UpdateViewResponse {}))
    }

    async fn pick(
        &self,
        request: Request<v1::PickRequest>,
    ) -> Result<Response<v1::PickResponse>, Status> {
        let walks = self.walks(request.metadata(), &request.get_ref().scene);
        let request = request.into_inner();
        let view = view_of(request.view).map_err(|e| status::invalid(&e.within("view")))?;
        let asked = DVec2::new(view.width.into(), view.height.into());
        let wanted = Wanted::new(1, view, &self.options);
        let wanted = wanted.map_err(|e| status::invalid(&e.within("view")))?;
        let pixel = request.pixel.ok_or_else(|| FieldError::new("", "is absent"));
        let pixel = pixel.and_then(|pixel| within(pixel, asked));
        let pixel = pixel.map_err(|e| status::invalid(&e.within("pixel")))?;
        let pixel = pixel * wanted.view.size().as_dvec2() / asked;
        let scene = self.scenes()?.open(&request.scene).await?;
        // Who walks has seen what is there; for anyone else it is loaded first, and stays meanwhile.
        let _loaded = if walks {
            None
        } else {
            let place = self.place()?;
            let (scene, wanted) = (Arc::clone(&scene), wanted.clone());
            let still = Still::paint(scene, wanted, Wish::default(), &self.options).await?;
            Some((still.visit, place))
        };
        // Loading takes long, and is nobody's turn.
        let _turn = self.picks.acquire().await;
        let place = pick::place(&scene, wanted, pixel, request.photographs).await?;
        Ok(Response::new(v1::PickResponse { place }))
    }
}

/// A place of a picture of `size`.
fn within(pixel: v1::Point2, size: DVec2) -> Result<DVec2, FieldError> {
    let pixel = DVec2::try_from(pixel)?;
    for (field, value, most) in [("x", pixel.x, size.x), ("y", pixel.y, size.y)] {
        if !(0.0..=most).contains(&value) {
            return Err(FieldError::new(field, format!("is {value}, must be 0 to {most}")));
        }
    }
    Ok(pixel)
}

fn view_of(view: Option<v1::View>) -> Result<v1::View, FieldError> {
    view.ok_or_else(|| FieldError::new("", "is absent"))
}

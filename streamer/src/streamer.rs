//! The streamer itself: one scene, one receiver of updates.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};

use flaneur_scene::{ImageId, ImageUpdate, Panorama, PointNodeId, SceneInfo, SceneUpdate};
use futures::Stream;
use glam::DVec3;
use tokio::sync::mpsc;
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};

use crate::cache::{Cache, CacheOptions};
use crate::decode::{Picture, SurveyedPoint};
use crate::load::Loader;
use crate::plan::Order;
use crate::servers::Servers;
use crate::session::{self, Command, Counts, Driver, Statistics};
use crate::{Client, Event, StreamError, ViewRequest};

/// Updates that may wait for their receiver.
const QUEUE: usize = 16;

/// How a scene is streamed.
#[derive(Clone, Debug)]
pub struct StreamOptions {
    /// What is kept of what was fetched.
    pub cache: CacheOptions,
    /// What comes first.
    pub order: Order,
}

impl Default for StreamOptions {
    /// A quarter of a gigabyte in memory, nothing on disk.
    fn default() -> Self {
        let cache = CacheOptions { memory_bytes: 256 << 20, disk: None };
        Self { cache, order: Order::default() }
    }
}

/// Streams one scene to one receiver, whose holdings it keeps account of: what the receiver
/// already holds is not sent again, and what a view no longer wants is dropped.
#[derive(Debug)]
pub struct Streamer {
    loader: Arc<Loader>,
    order: Order,
    commands: mpsc::UnboundedSender<Command>,
    events: mpsc::Receiver<Event>,
    view: u64,
    counts: Arc<Counts>,
}

impl Streamer {
    /// Asks the servers what `scene` holds. Must be called within a tokio runtime, as all that
    /// follows.
    ///
    /// # Errors
    /// Where no server answers, or none has the scene.
    pub async fn connect(servers: impl Into<Servers>, scene: &str) -> Result<Self, StreamError> {
        Self::connect_with(servers, scene, StreamOptions::default()).await
    }

    /// The same with other than the default options.
    ///
    /// # Errors
    /// As above, and where the cache's folder cannot be one.
    pub async fn connect_with(
        servers: impl Into<Servers>,
        scene: &str,
        options: StreamOptions,
    ) -> Result<Self, StreamError> {
        let cache = Cache::new(&options.cache)?;
        let client = Client::new(servers, scene);
        let scene = Arc::new(client.scene().await?);
        Ok(Self::with(Arc::new(Loader::new(client, scene, cache)), options.order))
    }

    /// A streamer of the same scene for another receiver. Both share the cache and the connections,
    /// and what both want at once comes once.
    #[must_use]
    pub fn beside(&self) -> Self {
        Self::with(Arc::clone(&self.loader), self.order)
    }

    fn with(loader: Arc<Loader>, order: Order) -> Self {
        let (commands, orders) = mpsc::unbounded_channel();
        let (sender, events) = mpsc::channel(QUEUE);
        let counts = Arc::<Counts>::default();
        let driver = Driver::new(Arc::clone(&loader), order, Arc::clone(&counts), orders, sender);
        tokio::spawn(driver.run());
        Self { loader, order, commands, events, view: 0, counts }
    }

    /// What the scene holds.
    pub fn info(&self) -> &SceneInfo {
        self.loader.scene()
    }

    /// The client, for calls beside the stream.
    pub fn client(&self) -> &Client {
        self.loader.client()
    }

    /// What has passed since it connected. Bytes, requests and cached parts are those of all that
    /// share its connections.
    pub fn statistics(&self) -> Statistics {
        let traffic = self.client().traffic();
        let cache = self.loader.cache().statistics();
        let own = self.counts.read();
        Statistics {
            bytes_received: traffic.bytes(),
            bytes_wasted: own.bytes_wasted + traffic.abandoned_bytes(),
            requests: traffic.requests(),
            failovers: self.client().servers().failovers(),
            cache_hits: cache.memory_hits + cache.disk_hits,
            cache_misses: cache.misses,
            ..own
        }
    }

    /// Returns once everything that was fetched so far, and is to be kept on disk, is there.
    pub async fn flush(&self) {
        self.loader.cache().flush().await;
    }

    /// The photograph `id` of `panorama` as it is stored: its finest level with its mask, a face
    /// of a sphere resampled. `None` where the panorama has none of that name. The receiver's
    /// holdings do not change.
    ///
    /// # Errors
    /// Where the service fails, or sends what is no such picture.
    pub async fn photograph(
        &self,
        panorama: &Arc<Panorama>,
        id: &ImageId,
    ) -> Result<Option<Arc<ImageUpdate>>, StreamError> {
        session::photograph(&self.loader, panorama, id).await
    }

    /// The picture of a camera of `panorama`, by its index, whole as it is stored at a level, without its
    /// mask. `None` where the panorama has no such camera. The receiver's holdings do not change.
    ///
    /// # Errors
    /// Where the service fails, or sends what is no such picture.
    pub async fn picture(
        &self,
        panorama: &Arc<Panorama>,
        camera: usize,
        level: u32,
    ) -> Result<Option<Picture>, StreamError> {
        session::picture(&self.loader, panorama, camera, level).await
    }

    /// The surveyed point that is nearest to `place` (world) and within `reach_m` metres of it, of the
    /// nodes that are `shown`; `None` where there is none.
    ///
    /// # Errors
    /// Where the service fails, or sends what are no such points.
    pub async fn point_at(
        &self,
        place: DVec3,
        reach_m: f64,
        shown: impl Fn(&PointNodeId) -> bool + Sync,
    ) -> Result<Option<SurveyedPoint>, StreamError> {
        session::point_at(&self.loader, place, reach_m, &shown).await
    }

    /// Looks at something from now on; the number of this view, by which its progress is told. What
    /// only an earlier view wants is not fetched any more, and ends on the wire.
    pub fn look(&mut self, request: ViewRequest) -> u64 {
        self.view += 1;
        self.send(Command::Look(self.view, Some(Box::new(request))));
        self.view
    }

    /// Fetches nothing any more. What the receiver holds stays.
    pub fn rest(&mut self) {
        self.view += 1;
        self.send(Command::Look(self.view, None));
    }

    /// The next event, as soon as there is one. It may wait for long where nothing is to be done.
    /// An update counts as held by the receiver.
    pub async fn next(&mut self) -> Event {
        match self.events.recv().await {
            Some(event) => event,
            // The driver lives as long as this does, unless the runtime goes down.
            None => std::future::pending().await,
        }
    }

    /// The next event if there is one by now.
    pub fn try_next(&mut self) -> Option<Event> {
        self.events.try_recv().ok()
    }

    /// Takes note of what the receiver did by itself: dropped to make room, say. What it does not
    /// hold any more is sent again once a view wants it.
    pub fn note(&self, update: &SceneUpdate) {
        self.send(Command::Note(update.clone()));
    }

    /// Takes note that the receiver holds a photograph at another level than it was sent: where a
    /// view wants that one it is sent again.
    pub fn note_level(&self, id: &ImageId, level: u32) {
        self.send(Command::NoteLevel(id.clone(), level));
    }

    /// Everything that `request` wants and the receiver does not hold, what lowers the error of the
    /// picture most first; then what is to be dropped. Once the stream has ended, the receiver
    /// holds what the request alone determines, unless it is for
    /// [walking](ViewRequest::walking): the same over a network and in process, and whatever was
    /// streamed before.
    ///
    /// An error ends the stream, as does `cancel`, with [`StreamError::Cancelled`]. Dropping
    /// the stream ends its requests on the wire.
    pub fn stream(&mut self, request: ViewRequest, cancel: &CancellationToken) -> Events<'_> {
        let view = self.look(request);
        let cancelled = Box::pin(cancel.clone().cancelled_owned());
        Events { streamer: self, view, cancelled, ended: false }
    }

    fn send(&self, command: Command) {
        // The driver lives as long as this does, unless the runtime goes down.
        drop(self.commands.send(command));
    }
}

/// The events of one view. It borrows the streamer: one view is streamed at a time.
#[derive(Debug)]
pub struct Events<'a> {
    streamer: &'a mut Streamer,
    view: u64,
    cancelled: Pin<Box<WaitForCancellationFutureOwned>>,
    ended: bool,
}

impl Events<'_> {
    /// See [`Streamer::note`].
    pub fn note(&self, update: &SceneUpdate) {
        self.streamer.note(update);
    }

    /// See [`Streamer::note_level`].
    pub fn note_level(&self, id: &ImageId, level: u32) {
        self.streamer.note_level(id, level);
    }
}

impl Stream for Events<'_> {
    type Item = Result<Event, StreamError>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        if self.ended {
            return Poll::Ready(None);
        }
        if self.cancelled.as_mut().poll(context).is_ready() {
            self.ended = true;
            self.streamer.rest();
            return Poll::Ready(Some(Err(StreamError::Cancelled)));
        }
        loop {
            match ready!(self.streamer.events.poll_recv(context)) {
                Some(Event::Fault { view, .. }) if view != self.view => {}
                Some(Event::Fault { error, .. }) => {
                    self.ended = true;
                    self.streamer.rest();
                    return Poll::Ready(Some(Err(error)));
                }
                Some(Event::Progress(progress)) if progress.view != self.view => {}
                Some(event) => {
                    let is_last = matches!(&event, Event::Progress(progress) if progress.finished);
                    self.ended = is_last;
                    return Poll::Ready(Some(Ok(event)));
                }
                None => {
                    self.ended = true;
                    return Poll::Ready(Some(Err(StreamError::Cancelled)));
                }
            }
        }
    }
}

impl Drop for Events<'_> {
    fn drop(&mut self) {
        if !self.ended {
            self.streamer.rest();
        }
    }
}

//! A streamer that is told where one looks while it streams.

use flaneur_renderer::Applied;
use flaneur_scene::{SceneUpdate, View};
use flaneur_streamer::{Client, Event, StreamError, Streamer, ViewRequest};
use futures::StreamExt;
use tokio::sync::{mpsc, watch};
use tokio_util::sync::{CancellationToken, DropGuard};

use crate::exit::Exit;
use crate::source::{note, stream_exit};

/// A view this near to the one that is streamed, metres and cosine of the angle, does not stop it.
const NEAR: (f64, f64) = (3.0, 0.94);

/// Updates for the latest view.
pub(super) struct Feed {
    client: Client,
    views: watch::Sender<ViewRequest>,
    notes: mpsc::UnboundedSender<Applied>,
    events: mpsc::Receiver<(View, Result<Event, StreamError>)>,
    finished: Option<View>,
    complete: bool,
    _stop: DropGuard,
}

impl Feed {
    /// Begins with `request`.
    pub(super) fn new(mut streamer: Streamer, request: ViewRequest) -> Self {
        let client = streamer.client().clone();
        let (views, mut view) = watch::channel(request);
        let (notes, mut noted) = mpsc::unbounded_channel::<Applied>();
        let (sender, events) = mpsc::channel(4);
        let stop = CancellationToken::new();
        let stopped = stop.clone();
        tokio::spawn(async move {
            loop {
                let request = view.borrow_and_update().clone();
                let mut events = streamer.stream(request.clone(), &stopped);
                let ended = loop {
                    tokio::select! {
                        biased;
                        Some(applied) = noted.recv() => note(&mut events, &applied),
                        changed = view.changed() => match changed {
                            Ok(()) if near(&view.borrow().view, &request.view) => {}
                            Ok(()) => break false,
                            Err(_) => return,
                        },
                        event = events.next() => match event {
                            Some(event) => {
                                if sender.send((request.view, event)).await.is_err() {
                                    return;
                                }
                            }
                            None => break true,
                        },
                    }
                };
                drop(events);
                if ended && view.borrow().view == request.view && view.changed().await.is_err() {
                    return;
                }
            }
        });
        let _stop = stop.drop_guard();
        Self { client, views, notes, events, finished: None, complete: false, _stop }
    }

    /// Where one looks from now on.
    pub(super) fn look(&mut self, request: ViewRequest) {
        // Where nobody takes it the events have ended with an error.
        let _ = self.views.send(request);
    }

    /// What arrives next for the renderer; waits for it. `None` for a report.
    pub(super) async fn next(&mut self) -> Result<Option<SceneUpdate>, Exit> {
        let event = self.events.recv().await;
        event.map_or(Err(Exit::failed(anyhow::anyhow!("streaming has ended"))), |e| self.take(e))
    }

    /// What has arrived.
    pub(super) fn try_next(&mut self) -> Result<Option<Option<SceneUpdate>>, Exit> {
        match self.events.try_recv() {
            Ok(event) => self.take(event).map(Some),
            Err(_) => Ok(None),
        }
    }

    /// Tells it what the renderer did by itself.
    pub(super) fn note(&self, applied: Applied) {
        let _ = self.notes.send(applied);
    }

    /// Whether a complete, if coarse, picture has arrived.
    pub(super) fn complete_picture(&self) -> bool {
        self.complete
    }

    /// Whether all that `view` wants has arrived.
    pub(super) fn has_all(&self, view: &View) -> bool {
        self.finished.as_ref() == Some(view)
    }

    pub(super) fn bytes_received(&self) -> u64 {
        self.client.bytes_received()
    }

    pub(super) fn requests(&self) -> u64 {
        self.client.requests()
    }

    fn take(
        &mut self,
        (view, event): (View, Result<Event, StreamError>),
    ) -> Result<Option<SceneUpdate>, Exit> {
        match event.map_err(stream_exit)? {
            Event::Update(update) => {
                // Points follow the coarse photographs.
                self.complete |= matches!(update, SceneUpdate::Points(_));
                Ok(Some(update))
            }
            Event::Progress(progress) => {
                if progress.finished {
                    (self.finished, self.complete) = (Some(view), true);
                }
                Ok(None)
            }
        }
    }
}

fn near(a: &View, b: &View) -> bool {
    let (metres, cosine) = NEAR;
    a.eye().distance(b.eye()) < metres && a.camera.forward().dot(b.camera.forward()) > cosine
}

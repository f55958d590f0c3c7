//! A streamer, and what it has said so far.

use flaneur_renderer::Applied;
use flaneur_scene::SceneUpdate;
use flaneur_streamer::{Event, Statistics, Streamer, ViewRequest};

use crate::source;

/// Updates for the latest view.
pub(super) struct Feed {
    streamer: Streamer,
    /// The number of the latest view.
    view: u64,
    complete_at: Option<u64>,
    has_all: bool,
}

impl Feed {
    /// One that was asked for nothing yet.
    pub(super) fn new(streamer: Streamer) -> Self {
        Self { streamer, view: 0, complete_at: None, has_all: false }
    }

    /// Where one looks from now on.
    pub(super) fn look(&mut self, request: ViewRequest) {
        self.view = self.streamer.look(request);
        self.has_all = false;
    }

    /// What arrives next for the renderer; waits for it. `None` for a report.
    pub(super) async fn next(&mut self) -> Option<SceneUpdate> {
        let event = self.streamer.next().await;
        self.take(event)
    }

    /// The same of what has arrived; `None` where nothing has.
    pub(super) fn try_next(&mut self) -> Option<Option<SceneUpdate>> {
        let event = self.streamer.try_next()?;
        Some(self.take(event))
    }

    /// Tells it what the renderer did by itself.
    pub(super) fn note(&self, applied: &Applied) {
        source::tell(&self.streamer, applied);
    }

    /// Bytes received when a complete, if coarse, picture had arrived.
    pub(super) fn complete_at(&self) -> Option<u64> {
        self.complete_at
    }

    /// Whether all that the latest view wants has arrived.
    pub(super) fn has_all(&self) -> bool {
        self.has_all
    }

    /// What has passed.
    pub(super) fn statistics(&self) -> Statistics {
        self.streamer.statistics()
    }

    fn take(&mut self, event: Event) -> Option<SceneUpdate> {
        match event {
            Event::Update(update) => Some(update),
            Event::Progress(progress) => {
                let is_complete = progress.complete_picture || progress.finished;
                let bytes = progress.complete_at.unwrap_or(progress.bytes_received);
                self.complete_at = self.complete_at.or(is_complete.then_some(bytes));
                self.has_all |= progress.view == self.view && progress.finished;
                None
            }
            Event::Fault { error, .. } => {
                tracing::warn!(
                    error = &error as &dyn std::error::Error,
                    "the walk goes on without"
                );
                None
            }
        }
    }
}

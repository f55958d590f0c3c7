//! What the streamer has said of the latest view.

use flaneur_renderer::Applied;
use flaneur_scene::SceneUpdate;
use flaneur_streamer::{Event, StreamError, Streamer, ViewRequest};

use crate::source;

/// A streamer, and how far it is.
pub(super) struct Feed {
    pub(super) streamer: Streamer,
    view: u64,
    /// Tiles, images and nodes that are still to come.
    pub(super) remaining: u64,
    /// All that the latest view wants, and that can be had, has come.
    pub(super) has_all: bool,
}

/// What an event brings.
pub(super) enum Brought {
    Update(SceneUpdate),
    Fault(StreamError),
    Nothing,
}

impl Feed {
    /// One that was asked for nothing yet.
    pub(super) fn new(streamer: Streamer) -> Self {
        Self { streamer, view: 0, remaining: 0, has_all: false }
    }

    /// What is wanted from now on.
    pub(super) fn look(&mut self, request: ViewRequest) {
        self.view = self.streamer.look(request);
        self.has_all = false;
    }

    /// Takes note of an event.
    pub(super) fn take(&mut self, event: Event) -> Brought {
        match event {
            Event::Update(update) => Brought::Update(update),
            Event::Progress(progress) if progress.view == self.view => {
                self.remaining = progress.remaining;
                self.has_all = progress.finished;
                Brought::Nothing
            }
            Event::Fault { view, error } if view == self.view => Brought::Fault(error),
            Event::Progress(_) | Event::Fault { .. } => Brought::Nothing,
        }
    }

    /// Tells it what the renderer did by itself.
    pub(super) fn note(&self, applied: &Applied) {
        source::tell(&self.streamer, applied);
    }
}

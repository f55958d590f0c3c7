//! What a streamer brings for the view that one looks at.

use flaneur_renderer::Applied;
use flaneur_scene::{SceneUpdate, View};
use flaneur_streamer::{Event, Statistics, Streamer, ViewRequest};

use crate::exit::Exit;
use crate::source::stream_exit;

/// Updates for the latest view.
pub(super) struct Feed {
    streamer: Streamer,
    /// The view that is looked at, and its number.
    looking: (u64, View),
    /// The view of which everything is there.
    finished: Option<View>,
    complete: bool,
}

impl Feed {
    /// Begins with `request`.
    pub(super) fn new(mut streamer: Streamer, request: ViewRequest) -> Self {
        let view = request.view;
        let looking = (streamer.look(request), view);
        Self { streamer, looking, finished: None, complete: false }
    }

    /// Where one looks from now on.
    pub(super) fn look(&mut self, request: ViewRequest) {
        if self.looking.1 != request.view {
            let view = request.view;
            self.looking = (self.streamer.look(request), view);
        }
    }

    /// What arrives next for the renderer; waits for it. `None` for a report.
    pub(super) async fn next(&mut self) -> Result<Option<SceneUpdate>, Exit> {
        let event = self.streamer.next().await;
        self.take(event)
    }

    /// What has arrived.
    pub(super) fn try_next(&mut self) -> Result<Option<Option<SceneUpdate>>, Exit> {
        self.streamer.try_next().map(|event| self.take(event)).transpose()
    }

    /// Tells it what the renderer did by itself.
    pub(super) fn note(&self, applied: &Applied) {
        applied.evicted.iter().for_each(|dropped| self.streamer.note(dropped));
        applied.coarser.iter().for_each(|(id, level)| self.streamer.note_level(id, *level));
    }

    /// Whether a complete, if coarse, picture has arrived.
    pub(super) fn complete_picture(&self) -> bool {
        self.complete
    }

    /// Whether all that `view` wants has arrived.
    pub(super) fn has_all(&self, view: &View) -> bool {
        self.finished.as_ref() == Some(view)
    }

    pub(super) fn statistics(&self) -> Statistics {
        self.streamer.statistics()
    }

    fn take(&mut self, event: Event) -> Result<Option<SceneUpdate>, Exit> {
        match event {
            Event::Update(update) => Ok(Some(update)),
            Event::Progress(progress) => {
                self.complete |= progress.complete_picture;
                let (number, view) = self.looking;
                if progress.finished && progress.view == number {
                    self.finished = Some(view);
                }
                Ok(None)
            }
            Event::Fault { error, .. } => Err(stream_exit(error)),
        }
    }
}

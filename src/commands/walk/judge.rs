//! Comparing what was on screen with the same views fully loaded.

use flaneur_renderer::{Gpu, Renderer, Settings};
use flaneur_scene::View;
use flaneur_services::ingest::{Progress, Unit};
use flaneur_streamer::{Event, FetchLimits, Streamer, ViewRequest};
use futures::StreamExt;
use tokio_util::sync::CancellationToken;

use super::kept::Kept;
use crate::evaluation::walk::Sample;
use crate::exit::Exit;
use crate::progress::Console;
use crate::source::{Source, note, stream_exit};

/// A renderer that is given all that a view wants, past the throttled connection.
pub(super) struct Judge {
    streamer: Streamer,
    renderer: Renderer,
    limits: FetchLimits,
    cancel: CancellationToken,
}

impl Judge {
    /// One with empty hands. It stops when `cancel` is cancelled.
    pub(super) async fn new(
        source: &Source,
        gpu: &Gpu,
        settings: Settings,
        limits: FetchLimits,
        cancel: CancellationToken,
    ) -> Result<Self, Exit> {
        let streamer = source.streamer().await?;
        let renderer = Renderer::with_settings(gpu, settings);
        Ok(Self { streamer, renderer, limits, cancel })
    }

    /// Adds the sample of each kept frame to `samples`, in order.
    pub(super) async fn judge(
        &mut self,
        kept: &mut Kept,
        samples: &mut Vec<Sample>,
        console: &Console,
    ) -> Result<(), Exit> {
        let stage = console.stage("compare", kept.frames().len() as u64, Unit::Images);
        let mut whole: Option<(View, Vec<u8>)> = None;
        for index in 0..kept.frames().len() {
            let Some(&shown) = kept.frames().get(index) else { break };
            if whole.as_ref().is_none_or(|(view, _)| *view != shown.view) {
                whole = Some((shown.view, self.whole(&shown.view).await?));
            }
            tokio::task::yield_now().await;
            if self.cancel.is_cancelled() {
                return Err(Exit::Interrupted);
            }
            let Some((_, reference)) = &whole else { break };
            let sample = tokio::task::block_in_place(|| {
                let pixels = kept.pixels(index)?;
                let size = shown.view.size();
                Ok::<_, Exit>(Sample::new(shown.ms, shown.bytes, &pixels, reference, size))
            })?;
            samples.extend(sample);
            stage.advance(1);
        }
        Ok(())
    }

    /// The view with all that it wants, sRGB, three bytes a pixel.
    async fn whole(&mut self, view: &View) -> Result<Vec<u8>, Exit> {
        self.renderer.expect_eye(view.eye());
        let request = ViewRequest { limits: self.limits, ..ViewRequest::new(*view) };
        let mut events = self.streamer.stream(request, &self.cancel);
        while let Some(event) = events.next().await {
            if let Event::Update(update) = event.map_err(stream_exit)? {
                let applied = tokio::task::block_in_place(|| self.renderer.apply(update))?;
                note(&mut events, &applied);
            }
        }
        let frame = tokio::task::block_in_place(|| {
            // A picture of its own, whatever was rendered before it.
            self.renderer.cut();
            self.renderer.render(view)
        })?;
        Ok(frame.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect())
    }
}

//! Renderers, each with its own holdings.

use flaneur_renderer::{Frame, Gpu, Mode, PassTime, Renderer, Settings};
use flaneur_scene::{SceneUpdate, View};
use flaneur_streamer::{Budget, Event, Streamer, ViewRequest};
use futures::StreamExt;

use super::Context;
use crate::evaluation::speed::Feed;
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::source::{Source, note, stream_exit};

/// A renderer and what feeds it.
pub(super) struct Fed {
    feed: Feed,
    streamer: Streamer,
    renderer: Renderer,
    gpu_memory: GpuMemory,
}

impl Fed {
    /// An empty renderer.
    pub(super) async fn new(
        feed: Feed,
        source: &Source,
        gpu: &Gpu,
        settings: Settings,
        gpu_memory: GpuMemory,
    ) -> Result<Self, Exit> {
        let streamer = source.streamer().await?;
        let renderer = Renderer::with_settings(gpu, settings);
        Ok(Self { feed, streamer, renderer, gpu_memory })
    }

    /// Brings what `view` wants for `rigs` rigs.
    pub(super) async fn fetch(
        &mut self,
        view: &View,
        rigs: usize,
        context: &Context,
    ) -> Result<(), Exit> {
        let budget = Budget { panoramas: rigs, ..Budget::default() };
        let mut budget = self.gpu_memory.fitted(budget);
        self.renderer.expect_eye(view.eye());
        match self.feed {
            Feed::CoarserImages(parts) => budget.image_pixels /= u64::from(parts),
            Feed::AndBehind => {
                // What it held is gone first; what is behind stays when the view ahead comes.
                self.stream(&behind(view), budget, true, context).await?;
                return self.stream(view, budget, false, context).await;
            }
            Feed::Whole | Feed::Normals => {}
        }
        self.stream(view, budget, true, context).await
    }

    /// Renders with `settings` once for nobody, then once as a whole, then pass by pass. The
    /// times of the first are given, too.
    pub(super) fn measure(&mut self, view: &View, settings: Settings) -> Result<Measured, Exit> {
        if !self.renderer.set_settings(settings) {
            return Err(Exit::failed(anyhow::anyhow!(
                "the renderer cannot go on with {settings:?}"
            )));
        }
        // Variants are compared as they are, not on their way from one to the next.
        self.renderer.cut();
        let (_, first) = self.renderer.render_timed(view, Mode::Hybrid)?;
        let started = std::time::Instant::now();
        let frame = self.renderer.render(view)?;
        let frame_ms = started.elapsed().as_secs_f64() * 1e3;
        let (_, passes) = self.renderer.render_timed(view, Mode::Hybrid)?;
        Ok(Measured { frame, frame_ms, first, passes })
    }

    /// The depths of the frame that was rendered last.
    pub(super) fn depths(&self) -> Result<Vec<Option<f32>>, Exit> {
        Ok(self.renderer.last_depths()?)
    }

    async fn stream(
        &mut self,
        view: &View,
        budget: Budget,
        drops: bool,
        context: &Context,
    ) -> Result<(), Exit> {
        let normals = self.feed == Feed::Normals;
        let request = ViewRequest { budget, normals, ..ViewRequest::new(*view) };
        let mut events = self.streamer.stream(request, &context.cancel);
        while let Some(event) = events.next().await {
            let Event::Update(update) = event.map_err(stream_exit)? else { continue };
            if drops || !is_drop(&update) {
                let applied = tokio::task::block_in_place(|| self.renderer.apply(update))?;
                note(&mut events, &applied);
            }
        }
        Ok(())
    }
}

/// What one variant gave of one view.
pub(super) struct Measured {
    pub(super) frame: Frame,
    pub(super) frame_ms: f64,
    /// The passes right after the settings were changed.
    pub(super) first: Vec<PassTime>,
    pub(super) passes: Vec<PassTime>,
}

fn is_drop(update: &SceneUpdate) -> bool {
    match update {
        SceneUpdate::DropMesh(_) | SceneUpdate::DropImage(_) | SceneUpdate::DropPoints(_) => true,
        SceneUpdate::Mesh(_) | SceneUpdate::Image(_) | SceneUpdate::Points(_) => false,
    }
}

/// The view that looks the other way.
fn behind(view: &View) -> View {
    let mut behind = *view;
    let rotation = &mut behind.camera.cam_from_world;
    // Half a turn about the camera's vertical axis.
    *rotation = glam::DMat3::from_diagonal(glam::DVec3::new(-1.0, 1.0, -1.0)) * *rotation;
    behind
}

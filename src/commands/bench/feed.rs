//! Renderers, each with its own holdings.

use flaneur_renderer::{
    Frame, Gpu, MemoryReport, Mode, PassTime, Renderer, Settings, SplatNormals,
};
use flaneur_scene::{SceneUpdate, View};
use flaneur_streamer::{Event, FetchLimits, Streamer, ViewRequest};
use futures::StreamExt;

use super::Context;
use crate::evaluation::StatedSettings;
use crate::evaluation::speed::Feed;
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::source::{Source, note, stream_exit};

/// Frames that take longer than this are not repeated, milliseconds.
const LONG_MS: f64 = 2000.0;

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
        let limits = FetchLimits { panoramas: rigs, ..FetchLimits::default() };
        let mut limits = self.gpu_memory.fitted(limits);
        self.renderer.expect_eye(view.eye());
        match self.feed {
            Feed::CoarserImages(parts) => limits.image_pixels /= u64::from(parts),
            Feed::AndBehind => {
                // What it held is gone first; what is behind stays when the view ahead comes.
                self.stream(&behind(view), limits, true, context).await?;
                return self.stream(view, limits, false, context).await;
            }
            Feed::Whole | Feed::OnPlanes => {}
        }
        self.stream(view, limits, true, context).await
    }

    /// Renders with `settings` once for nobody, then `repeats` times as a whole, then pass by pass.
    /// The times of the first are given, too. What takes long is rendered as a whole only once.
    pub(super) fn measure(
        &mut self,
        view: &View,
        settings: Settings,
        repeats: usize,
    ) -> Result<Measured, Exit> {
        self.set(settings)?;
        // Variants are compared as they are, not on their way from one to the next.
        self.renderer.cut();
        let (_, first) = self.renderer.render_timed(view, Mode::Hybrid)?;
        let (frame, ms) = self.timed(view)?;
        let mut frame_ms = vec![ms];
        while frame_ms.len() < repeats && ms < LONG_MS {
            frame_ms.push(self.timed(view)?.1);
        }
        let (_, passes) = self.renderer.render_timed(view, Mode::Hybrid)?;
        Ok(Measured { frame, frame_ms, first, passes })
    }

    /// The frame that `settings` give, as it is on its own.
    pub(super) fn frame(&mut self, view: &View, settings: Settings) -> Result<Frame, Exit> {
        self.set(settings)?;
        self.renderer.cut();
        Ok(self.renderer.render(view)?)
    }

    /// The next frame, as it follows the one before, and how long it took, milliseconds.
    pub(super) fn timed(&mut self, view: &View) -> Result<(Frame, f64), Exit> {
        let started = std::time::Instant::now();
        let frame = self.renderer.render(view)?;
        Ok((frame, started.elapsed().as_secs_f64() * 1e3))
    }

    /// Has what comes rendered with `settings`.
    pub(super) fn set(&mut self, settings: Settings) -> Result<(), Exit> {
        if self.renderer.set_settings(settings) {
            return Ok(());
        }
        let settings = StatedSettings(settings);
        Err(Exit::failed(anyhow::anyhow!("the renderer cannot go on with {settings}")))
    }

    /// What feeds it.
    pub(super) fn feed(&self) -> Feed {
        self.feed
    }

    /// What the renderer holds on the device.
    pub(super) fn held(&self) -> MemoryReport {
        self.renderer.memory()
    }

    /// Brings what all of `path` wants, beside what is there.
    pub(super) async fn fetch_path(
        &mut self,
        path: &[View],
        rigs: usize,
        context: &Context,
    ) -> Result<(), Exit> {
        let limits = FetchLimits { panoramas: rigs, ..FetchLimits::default() };
        let limits = self.gpu_memory.fitted(limits);
        for view in path {
            self.renderer.expect_eye(view.eye());
            self.stream(view, limits, false, context).await?;
        }
        Ok(())
    }

    /// The depths of the frame that was rendered last.
    pub(super) fn depths(&self) -> Result<Vec<Option<f32>>, Exit> {
        Ok(self.renderer.last_depths()?)
    }

    async fn stream(
        &mut self,
        view: &View,
        limits: FetchLimits,
        drops: bool,
        context: &Context,
    ) -> Result<(), Exit> {
        let normals = self.renderer.settings().splat_normals == SplatNormals::Estimated;
        let request = ViewRequest { limits, normals, ..ViewRequest::new(*view) };
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
    /// Of each repeat.
    pub(super) frame_ms: Vec<f64>,
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

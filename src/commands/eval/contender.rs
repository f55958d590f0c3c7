//! One method at work.

use flaneur_renderer::{Gpu, Renderer, Settings};
use flaneur_scene::{ImageId, PosedCamera, SceneUpdate, View};
use flaneur_streamer::Streamer;

use super::target::stored;
use crate::evaluation::{Compared, Making, Method};
use crate::exit::Exit;
use crate::names::Names;

/// A method, with its own renderer where it needs one.
pub(super) struct Contender {
    /// The method.
    pub(super) method: &'static Method,
    renderer: Option<Renderer>,
}

impl Contender {
    /// The method with an empty renderer, whose settings start from `whole`.
    pub(super) fn new(method: &'static Method, gpu: Option<&Gpu>, whole: Settings) -> Self {
        let renderer = match (method.making, gpu) {
            (Making::Rendered { settings, .. }, Some(gpu)) => {
                Some(Renderer::with_settings(gpu, settings(whole)))
            }
            _ => None,
        };
        Self { method, renderer }
    }

    /// Passes an update on where the method takes it. Payloads are shared.
    pub(super) fn apply(&mut self, update: &SceneUpdate) -> Result<(), Exit> {
        match &mut self.renderer {
            Some(renderer) if self.method.making.takes(update) => {
                Ok(renderer.apply(update.clone())?)
            }
            _ => Ok(()),
        }
    }

    /// The picture that `camera` would take, of its size. `nearest` is the source that a method
    /// without a renderer shows.
    pub(super) async fn picture(
        &mut self,
        camera: &PosedCamera,
        nearest: &ImageId,
        names: &Names,
        streamer: &Streamer,
    ) -> Result<Compared, Exit> {
        match &mut self.renderer {
            Some(renderer) => tokio::task::block_in_place(|| {
                let frame = renderer.render(&View { camera: *camera })?;
                Ok(Compared::from(&frame))
            }),
            None => {
                let source = stored(nearest, names, streamer).await?;
                Ok(tokio::task::block_in_place(|| source.resized(camera.lens.size)))
            }
        }
    }
}

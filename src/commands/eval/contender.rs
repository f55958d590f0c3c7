//! The methods at work.

use flaneur_renderer::{Applied, Gpu, MemoryReport, Renderer, Settings, SplatNormals};
use flaneur_scene::{ImageId, PosedCamera, SceneUpdate, View};
use flaneur_streamer::Streamer;
use glam::DVec3;

use super::target::stored;
use crate::evaluation::{Compared, Making, Method};
use crate::exit::Exit;
use crate::names::Names;

/// The methods of one evaluation, with the renderers that they need.
pub(super) struct Contenders {
    methods: Vec<Contender>,
    renderers: Vec<Shared>,
}

/// One method.
struct Contender {
    method: &'static Method,
    /// Which renderer makes its picture, and how; none for a method without.
    rendered: Option<(usize, Settings)>,
}

/// A renderer of the methods that are given the same geometry and differ only in what is decided
/// anew for each frame: a scene on the device takes a gigabyte or more.
struct Shared {
    making: Making,
    settings: Settings,
    renderer: Renderer,
}

impl Contenders {
    /// The methods with empty renderers, whose settings start from `whole`. Without `gpu`, for
    /// methods that do not render.
    pub(super) fn new(methods: &[&'static Method], gpu: Option<&Gpu>, whole: Settings) -> Self {
        let mut renderers: Vec<Shared> = Vec::new();
        let contender = |&method: &&'static Method| {
            let rendered = method.making.settings(whole).zip(gpu).map(|(settings, gpu)| {
                let fits = |shared: &Shared| {
                    shared.making.takes_as(&method.making)
                        && shared.settings.differ_by_frame_only(&settings)
                };
                let index = renderers.iter().position(fits).unwrap_or_else(|| {
                    let renderer = Renderer::with_settings(gpu, settings);
                    renderers.push(Shared { making: method.making, settings, renderer });
                    renderers.len() - 1
                });
                (index, settings)
            });
            Contender { method, rendered }
        };
        Self { methods: methods.iter().map(contender).collect(), renderers }
    }

    /// How many methods there are.
    pub(super) fn len(&self) -> usize {
        self.methods.len()
    }

    /// Whether any makes use of the points' normals.
    pub(super) fn take_normals(&self) -> bool {
        self.renderers.iter().any(|of| of.settings.splat_normals == SplatNormals::Estimated)
    }

    /// Says where the next view is.
    pub(super) fn expect_eye(&mut self, eye: DVec3) {
        self.renderers.iter_mut().for_each(|shared| shared.renderer.expect_eye(eye));
    }

    /// Passes an update on to every renderer that takes it, and gives what became of it in each.
    /// Payloads are shared.
    pub(super) fn apply(&mut self, update: &SceneUpdate) -> Result<Vec<Applied>, Exit> {
        let mut applied = Vec::new();
        for shared in &mut self.renderers {
            if shared.making.takes(update) {
                applied.push(shared.renderer.apply(update.clone())?);
            }
        }
        Ok(applied)
    }

    /// What all renderers together hold on the device.
    pub(super) fn memory(&self) -> MemoryReport {
        let held = self.renderers.iter().map(|shared| shared.renderer.memory());
        held.fold(MemoryReport::default(), |all, of| all + of)
    }

    /// The name of the method `index`, and the picture that `camera` would take by it, of the
    /// camera's size. `nearest` is the source that a method without a renderer shows.
    pub(super) async fn picture(
        &mut self,
        index: usize,
        camera: &PosedCamera,
        nearest: &ImageId,
        names: &Names,
        streamer: &Streamer,
    ) -> Result<(&'static str, Compared), Exit> {
        let Contender { method, rendered } = &self.methods[index];
        let shared = rendered
            .and_then(|(renderer, settings)| Some((self.renderers.get_mut(renderer)?, settings)));
        let picture = match shared {
            Some((shared, settings)) => tokio::task::block_in_place(|| {
                shared.renderer.set_settings(settings);
                shared.renderer.cut();
                let frame = shared.renderer.render(&View::from(*camera))?;
                Ok::<_, Exit>(Compared::from(&frame))
            })?,
            None => {
                let source = stored(nearest, names, streamer).await?;
                tokio::task::block_in_place(|| source.resized(camera.lens.size))
            }
        };
        Ok((method.name, picture))
    }
}

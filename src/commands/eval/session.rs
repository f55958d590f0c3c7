//! One evaluation under way.

use std::collections::BTreeSet;
use std::sync::Arc;

use flaneur_renderer::{Gpu, Settings};
use flaneur_scene::{ImageId, View};
use flaneur_services::ingest::{Progress, Unit};
use flaneur_streamer::{Event, FetchLimits, Streamer, ViewRequest};
use futures::StreamExt;

use super::contender::Contenders;
use super::target::Target;
use super::{Context, EvalArguments, chosen};
use crate::evaluation::{
    Described, Gallery, Method, Report, Row, Score, StatedSettings, nearest_source,
};
use crate::exit::Exit;
use crate::memory::{GpuMemory, HeldMemory};
use crate::names::{Names, Pattern};
use crate::source::{Source, note, stream_exit};

/// All that the views of one evaluation share.
pub(super) struct Session {
    streamer: Streamer,
    names: Names,
    sources: Arc<BTreeSet<ImageId>>,
    targets: Vec<Target>,
    contenders: Contenders,
    gpu_memory: GpuMemory,
    adapter: Option<String>,
    memory: HeldMemory,
    described: Described,
}

impl Session {
    /// Connects, opens the graphics device meanwhile, and finds out what is held out.
    pub(super) async fn prepare(
        arguments: &EvalArguments,
        methods: &[&'static Method],
    ) -> Result<Self, Exit> {
        let is_rendered = |method: &&Method| method.making.settings(Settings::default()).is_some();
        let gpu = methods.iter().any(is_rendered).then(|| tokio::task::spawn_blocking(Gpu::new));
        let streamer = Source::open(&arguments.source).await?.streamer().await?;
        let names = Names::all(streamer.client()).await?;
        let (sources, targets) = chosen(arguments, &names)?;
        let gpu = match gpu {
            Some(gpu) => Some(gpu.await??),
            None => None,
        };
        let gpu_memory_bytes = arguments.gpu_memory.bytes();
        let settings = Settings { gpu_memory_bytes, ..Settings::default() };
        let described = Described {
            held_out: arguments.described(),
            only: arguments.only.iter().map(Pattern::to_string).collect(),
            sources: sources.len(),
            targets: targets.len(),
            methods: methods.iter().map(|method| method.name).collect(),
            renderer: StatedSettings(settings),
        };
        Ok(Self {
            gpu_memory: arguments.gpu_memory,
            contenders: Contenders::new(methods, gpu.as_ref(), settings),
            adapter: gpu.as_ref().map(|gpu| gpu.adapter_name().to_owned()),
            memory: HeldMemory::default(),
            streamer,
            names,
            sources: Arc::new(sources),
            targets,
            described,
        })
    }

    /// How many views there are.
    pub(super) fn targets(&self) -> usize {
        self.targets.len()
    }

    /// Renders and scores every view by every method, and shows them in `gallery`.
    pub(super) async fn run(
        &mut self,
        mut gallery: Option<&mut Gallery>,
        context: &Context,
    ) -> Result<Vec<Row>, Exit> {
        let pictures = self.targets.len() * self.contenders.len();
        let stage = context.console.stage("evaluate", pictures as u64, Unit::Images);
        let mut rows = Vec::with_capacity(pictures);
        for (index, target) in std::mem::take(&mut self.targets).iter().enumerate() {
            let photograph = target.photograph(&self.streamer).await?;
            let (nearest, nearest_m) = self.nearest(target)?;
            self.fetch(target, context).await?;
            if let Some(gallery) = &mut gallery {
                gallery.begin(index, &target.id, nearest_m, &photograph)?;
            }
            for method in 0..self.contenders.len() {
                // Rendering and measuring wait for nothing that would notice.
                if context.cancel.is_cancelled() {
                    return Err(Exit::Interrupted);
                }
                let (names, streamer) = (&self.names, &self.streamer);
                let picture =
                    self.contenders.picture(method, &target.camera, &nearest, names, streamer);
                let (method, picture) = picture.await?;
                self.memory.raise_to(self.contenders.memory());
                let score = tokio::task::block_in_place(|| {
                    let score = Score::new(&photograph, &picture).ok_or_else(|| {
                        Exit::failed(anyhow::anyhow!(
                            "{} is {} pixels, and its rendering {}",
                            target.id,
                            photograph.size,
                            picture.size
                        ))
                    })?;
                    if let Some(gallery) = &mut gallery {
                        gallery.add(index, method, &score, &photograph, &picture)?;
                    }
                    Ok::<_, Exit>(score)
                })?;
                rows.push(Row { id: target.id.clone(), nearest_m, method, score });
                stage.advance(1);
            }
        }
        Ok(rows)
    }

    /// What is said of it.
    pub(super) fn report(self, rows: Vec<Row>, methods: &[&'static Method]) -> Report {
        let scene = self.streamer.info().name.clone();
        Report::new(scene, self.adapter, self.memory, self.described, methods, rows)
    }

    /// Brings everything that the target's view wants to every renderer that takes it: one
    /// stream feeds them all.
    async fn fetch(&mut self, target: &Target, context: &Context) -> Result<(), Exit> {
        self.contenders.expect_eye(target.camera.centre);
        let sources = Arc::clone(&self.sources);
        let request = ViewRequest {
            excluded: Arc::new(move |id| !sources.contains(id)),
            normals: self.contenders.take_normals(),
            limits: self.gpu_memory.fitted(FetchLimits::default()),
            ..ViewRequest::new(View::from(target.camera))
        };
        let mut events = self.streamer.stream(request, &context.cancel);
        while let Some(event) = events.next().await {
            if let Event::Update(update) = event.map_err(stream_exit)? {
                let applied = tokio::task::block_in_place(|| self.contenders.apply(&update))?;
                applied.iter().for_each(|applied| note(&mut events, applied));
            }
        }
        Ok(())
    }

    /// The source that stands nearest to the target, and its distance in metres.
    fn nearest(&self, target: &Target) -> Result<(ImageId, f64), Exit> {
        let all = self.names.photographs().iter();
        let sources = all
            .filter(|(id, _)| self.sources.contains(*id))
            .map(|(id, photograph)| (id, &photograph.camera));
        let nearest = nearest_source(&target.camera, sources);
        nearest
            .map(|(id, nearest_m)| (id.clone(), nearest_m))
            .ok_or_else(|| Exit::bad_input(anyhow::anyhow!("the scene has no photograph")))
    }
}

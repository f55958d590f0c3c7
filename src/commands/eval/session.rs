//! One evaluation under way.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use flaneur_renderer::{Gpu, Settings};
use flaneur_scene::ImageId;
use flaneur_services::ingest::{Progress, Unit};
use flaneur_streamer::Streamer;

use super::contender::{Contender, Group};
use super::target::Target;
use super::{Context, EvalArguments, chosen};
use crate::evaluation::{
    Compared, Described, Gallery, Method, Report, Row, Score, StatedSettings, nearest_source,
};
use crate::exit::Exit;
use crate::memory::{GpuMemory, HeldMemory};
use crate::names::{Names, Pattern};
use crate::source::Source;

/// All that the views of one evaluation share.
pub(super) struct Session {
    source: Source,
    streamer: Streamer,
    names: Names,
    sources: Arc<BTreeSet<ImageId>>,
    targets: Vec<Target>,
    methods: Vec<&'static Method>,
    settings: Settings,
    gpu: Option<Gpu>,
    gpu_memory: GpuMemory,
    memory: HeldMemory,
    described: Described,
}

impl Session {
    /// Connects, opens the graphics device meanwhile, and finds out what is held out.
    pub(super) async fn prepare(
        arguments: &EvalArguments,
        methods: Vec<&'static Method>,
    ) -> Result<Self, Exit> {
        let is_rendered = |method: &&Method| method.making.settings(Settings::default()).is_some();
        let gpu = methods.iter().any(is_rendered).then(|| tokio::task::spawn_blocking(Gpu::new));
        let source = Source::open(&arguments.source).await?;
        let streamer = source.streamer().await?;
        let names = Names::all(streamer.client()).await?;
        let (sources, targets) = chosen(arguments, &names)?;
        let gpu = match gpu {
            Some(gpu) => Some(gpu.await??),
            None => None,
        };
        let gpu_memory = arguments.gpu_memory;
        let settings = Settings { gpu_memory_bytes: gpu_memory.bytes(), ..Settings::default() };
        let described = Described {
            held_out: arguments.described(),
            only: arguments.only.iter().map(Pattern::to_string).collect(),
            sources: sources.len(),
            targets: targets.len(),
            methods: methods.iter().map(|method| method.name).collect(),
            renderer: StatedSettings(settings),
        };
        Ok(Self {
            source,
            streamer,
            names,
            sources: Arc::new(sources),
            targets,
            methods,
            settings,
            gpu,
            gpu_memory,
            memory: HeldMemory::default(),
            described,
        })
    }

    /// How many views there are.
    pub(super) fn targets(&self) -> usize {
        self.targets.len()
    }

    /// Renders and scores every view by every method, and shows them in `gallery`.
    ///
    /// Groups of methods follow each other, each with a renderer that has all of the memory: what
    /// is held stays within its limit, and no method's pictures depend on which others take part.
    pub(super) async fn run(
        &mut self,
        mut gallery: Option<&mut Gallery>,
        context: &Context,
    ) -> Result<Vec<Row>, Exit> {
        let pictures = self.targets.len() * self.methods.len();
        let stage = context.console.stage("evaluate", pictures as u64, Unit::Images);
        let mut rows = BTreeMap::new();
        for group in Group::all(&self.methods, self.settings) {
            let streamer = self.source.streamer().await?;
            let mut contender =
                Contender::new(&group, self.gpu.as_ref(), streamer, self.gpu_memory);
            for (index, target) in self.targets.iter().enumerate() {
                let photograph = target.photograph(&self.streamer).await?;
                let (nearest, nearest_m) = self.nearest(target)?;
                contender.fetch(target.camera, &self.sources, context).await?;
                if let Some(gallery) = &mut gallery {
                    gallery.begin(index, &target.id, nearest_m, &photograph)?;
                }
                for member in group.members() {
                    // Rendering and measuring wait for nothing that would notice.
                    if context.cancel.is_cancelled() {
                        return Err(Exit::Interrupted);
                    }
                    let picture =
                        contender.picture(member, &target.camera, &nearest, &self.names).await?;
                    self.memory.raise_to(contender.memory());
                    let (place, method) = (member.place, member.method.name);
                    let score = tokio::task::block_in_place(|| {
                        let score = score(target, &photograph, &picture)?;
                        if let Some(gallery) = &mut gallery {
                            gallery.add(index, (place, method), &score, &photograph, &picture)?;
                        }
                        Ok::<_, Exit>(score)
                    })?;
                    let row = Row { id: target.id.clone(), nearest_m, method, score };
                    rows.insert((index, place), row);
                    stage.advance(1);
                }
            }
        }
        Ok(rows.into_values().collect())
    }

    /// What is said of it.
    pub(super) fn report(self, rows: Vec<Row>) -> Report {
        let scene = self.streamer.info().name.clone();
        let adapter = self.gpu.as_ref().map(|gpu| gpu.adapter_name().to_owned());
        Report::new(scene, adapter, self.memory, self.described, &self.methods, rows)
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

/// How far `picture` is from `photograph`, which are of one size.
fn score(target: &Target, photograph: &Compared, picture: &Compared) -> Result<Score, Exit> {
    Score::new(photograph, picture).ok_or_else(|| {
        Exit::failed(anyhow::anyhow!(
            "{} is {} pixels, and its rendering {}",
            target.id,
            photograph.size,
            picture.size
        ))
    })
}

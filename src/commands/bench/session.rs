//! One measurement under way.

use std::collections::BTreeMap;

use flaneur_renderer::{Gpu, Settings};
use flaneur_scene::View;
use flaneur_services::ingest::{Progress, Unit as Counted};
use glam::DVec3;

use super::feed::{Fed, Measured};
use super::growth::linearity;
use super::path::along_survey;
use super::tally::Tally;
use super::{BenchArguments, Context, views};
use crate::evaluation::speed::ladder::{RIGS, Single, Sweep};
use crate::evaluation::speed::{Described, Feed, FrontRung, Report, Row, Variant, variants};
use crate::exit::Exit;
use crate::memory::{GpuMemory, HeldMemory};
use crate::names::Names;
use crate::source::Source;
use crate::viewpoints::{Height, read_path};

/// All that the variants share.
pub(super) struct Session {
    scene: String,
    gpu: Gpu,
    source: Source,
    gpu_memory: GpuMemory,
    pub(super) views: Vec<View>,
    /// Where the view moves along.
    pub(super) path: Vec<View>,
    /// Of each view, once it was rendered.
    pub(super) exact: Vec<Exact>,
    described: Described,
    memory: HeldMemory,
    pub(super) variants: Vec<Variant>,
    tallies: Vec<Tally>,
    /// Those of budgets.
    pub(super) rows: Vec<Row>,
    pub(super) front: Vec<FrontRung>,
    pub(super) base: Settings,
    pub(super) repeats: usize,
}

impl Session {
    /// Connects, opens the graphics device meanwhile, and finds the views out.
    pub(super) async fn prepare(arguments: &BenchArguments) -> Result<Self, Exit> {
        let gpu = tokio::task::spawn_blocking(Gpu::new);
        let source = Source::open(&arguments.source).await?;
        let streamer = source.streamer().await?;
        let size = arguments.size;
        let names = Names::all(streamer.client()).await?;
        let views: Vec<View> = match &arguments.path {
            Some(path) => {
                let listed = read_path(path)?.into_iter();
                listed
                    .map(|l| l.viewpoint.view(Height::Degrees(arguments.fov), Some(size), size))
                    .collect()
            }
            None => views::chosen(&names, streamer.info(), arguments.fov, size.0),
        };
        let start = views.first().map_or(DVec3::ZERO, View::eye);
        let path = along_survey(&names, start, arguments.fov, size.0);
        let gpu = gpu.await??;
        let gpu_memory = arguments.gpu_memory;
        let base = Settings { gpu_memory_bytes: gpu_memory.bytes(), ..Settings::default() };
        let repeats = arguments.repeats as usize;
        let variants = variants(base, gpu.has_64_bit_atomics());
        Ok(Self {
            scene: streamer.info().name.clone(),
            described: Described::new(size.0, views.len(), repeats, base),
            tallies: variants.iter().map(|_| Tally::default()).collect(),
            gpu,
            source,
            gpu_memory,
            views,
            path,
            exact: Vec::new(),
            memory: HeldMemory::default(),
            variants,
            rows: Vec::new(),
            front: Vec::new(),
            base,
            repeats,
        })
    }

    /// Measures every view by every variant, then what frame budgets choose from, then budgets while
    /// the view moves. Variants that are fed alike take turns on one renderer, view by view; the
    /// renderers follow each other, because a machine may not hold several.
    pub(super) async fn run(&mut self, context: &Context) -> Result<(), Exit> {
        let renderings = self.views.len() * self.variants.len();
        let stage = context.console.stage("measure", renderings as u64, Counted::Items);
        // The first variant is the most exact one: its feed comes first.
        let feeds: BTreeMap<Feed, Settings> =
            self.variants.iter().rev().map(|variant| (variant.feed, variant.settings)).collect();
        for (feed, settings) in feeds {
            let mut fed =
                Fed::new(feed, &self.source, &self.gpu, settings, self.gpu_memory).await?;
            for (number, view) in self.views.clone().iter().enumerate() {
                fed.fetch(view, RIGS[0], context).await?;
                if number == self.exact.len() {
                    let exact = tokio::task::block_in_place(|| self.most_exact(&mut fed, view))?;
                    self.exact.push(exact);
                }
                for index in 0..self.variants.len() {
                    if self.variants.get(index).is_some_and(|variant| variant.feed == feed) {
                        check(context).await?;
                        let measure = || self.measure(&mut fed, index, view, number);
                        tokio::task::block_in_place(measure)?;
                        stage.advance(1);
                    }
                }
            }
            if feed == Feed::Whole {
                self.measure_front(&mut fed, context).await?;
                self.walk(&mut fed, context).await?;
            }
            self.memory.raise_to(fed.held());
        }
        self.compare_with_f64(context).await
    }

    /// The device.
    pub(super) fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Where the scene is read from.
    pub(super) fn source(&self) -> &Source {
        &self.source
    }

    /// What is said of it.
    pub(super) fn report(self) -> Report {
        let mut rows = Vec::new();
        for (variant, tally) in self.variants.iter().zip(&self.tallies) {
            rows.extend(tally.rows(variant));
        }
        rows.extend(self.rows);
        Report::mark_front(&mut rows);
        Report {
            scene: self.scene,
            adapter: self.gpu.adapter_name().to_owned(),
            software: self.gpu.is_software(),
            cpus: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            described: self.described,
            memory: self.memory,
            linearity: linearity(&self.variants, &self.tallies),
            front: self.front,
            rows,
        }
    }

    /// What each value of the settings that a frame budget changes costs alone.
    pub(super) fn sweep(&self) -> Option<Sweep> {
        let singles = |method: &str| -> Option<Vec<Single>> {
            let of = self.variants.iter().zip(&self.tallies);
            let values = of.filter(|(variant, _)| {
                variant.method == "most exact"
                    || variant.method == method && variant.feed == Feed::Whole
            });
            values.map(|(_, tally)| tally.single()).collect()
        };
        Some([
            singles("rigs")?,
            singles("points")?,
            singles("inferred depths")?,
            singles("alignment")?,
            singles("resolution")?,
        ])
    }

    /// The most exact frame of a view.
    fn most_exact(&self, fed: &mut Fed, view: &View) -> Result<Exact, Exit> {
        let variant = self.variants.first();
        let variant = variant.ok_or_else(|| Exit::failed(anyhow::anyhow!("nothing to compare")))?;
        let frame = fed.frame(view, variant.settings)?;
        Ok(Exact { frame, depths: fed.depths()? })
    }

    /// Measures the view `number` by the variant `index`.
    fn measure(
        &mut self,
        fed: &mut Fed,
        index: usize,
        view: &View,
        number: usize,
    ) -> Result<(), Exit> {
        let (Some(variant), Some(tally)) = (self.variants.get(index), self.tallies.get_mut(index))
        else {
            return Ok(());
        };
        let Measured { frame, frame_ms, first, mut passes } =
            fed.measure(view, variant.settings, self.repeats)?;
        // In a frame like the one before it depth maps take nothing: what counts is to draw them.
        for (pass, first) in passes.iter_mut().zip(first) {
            if pass.pass == DEPTH_MAPS {
                *pass = first;
            }
        }
        frame_ms.into_iter().for_each(|ms| tally.add_frame(ms));
        tally.add_passes(&passes);
        tally.add_bytes(fed.held().total());
        if let Some(exact) = self.exact.get(number) {
            tally.stats.push(frame.stats);
            tally.difference.add_colours(&frame, &exact.frame);
            let depths = fed.depths()?;
            // Of smaller pictures, other places would be compared.
            if depths.len() == exact.depths.len() {
                tally.difference.add_depths(&depths, &exact.depths);
            }
        }
        Ok(())
    }
}

/// The pass that is measured right after a change of settings.
const DEPTH_MAPS: &str = "depth maps";

/// Ends the run where it is to end. Rendering waits for nothing that would notice, so that other
/// tasks, Ctrl-C among them, have their turn here.
pub(super) async fn check(context: &Context) -> Result<(), Exit> {
    tokio::task::yield_now().await;
    if context.cancel.is_cancelled() { Err(Exit::Interrupted) } else { Ok(()) }
}

/// What variants are compared with.
pub(super) struct Exact {
    pub(super) frame: flaneur_renderer::Frame,
    depths: Vec<Option<f32>>,
}

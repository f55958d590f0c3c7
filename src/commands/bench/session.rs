//! One measurement under way.

use std::collections::BTreeMap;

use flaneur_renderer::{FrameStats, Gpu, PassTime, Settings};
use flaneur_scene::View;
use flaneur_services::ingest::{Progress, Unit as Counted};

use super::feed::{Fed, Measured};
use super::{BenchArguments, Context, views};
use crate::evaluation::speed::{
    Cost, Described, Difference, Feed, Inputs, Linearity, OffScreen, Report, Row, Unit, Variant,
    line_through, median, percentile, variants,
};
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::names::Names;
use crate::source::Source;
use crate::viewpoints::{Height, read_path};

/// All that the variants share.
pub(super) struct Session {
    scene: String,
    gpu: Gpu,
    source: Source,
    gpu_memory: GpuMemory,
    views: Vec<View>,
    /// Of each view, once it was rendered.
    exact: Vec<Exact>,
    described: Described,
    variants: Vec<Variant>,
    tallies: Vec<Tally>,
    base: Settings,
    repeats: usize,
}

/// What was measured of one variant.
#[derive(Debug, Default)]
struct Tally {
    /// Milliseconds of the frame and of each pass, in the order of a frame.
    times: Vec<(&'static str, Vec<f64>)>,
    difference: Difference,
    stats: Vec<FrameStats>,
}

impl Session {
    /// Connects, opens the graphics device meanwhile, and finds the views out.
    pub(super) async fn prepare(arguments: &BenchArguments) -> Result<Self, Exit> {
        let gpu = tokio::task::spawn_blocking(Gpu::new);
        let source = Source::open(&arguments.source).await?;
        let streamer = source.streamer().await?;
        let size = arguments.size;
        let views = match &arguments.path {
            Some(path) => {
                let listed = read_path(path)?.into_iter();
                listed
                    .map(|l| l.viewpoint.view(Height::Degrees(arguments.fov), Some(size), size))
                    .collect()
            }
            None => {
                let names = Names::all(streamer.client()).await?;
                views::chosen(&names, streamer.info(), arguments.fov, size.0)
            }
        };
        let gpu = gpu.await??;
        let gpu_memory = arguments.gpu_memory;
        let base = Settings { gpu_memory_bytes: gpu_memory.bytes(), ..Settings::default() };
        let repeats = arguments.repeats as usize;
        // How many points a view meets is not known before one was rendered.
        let variants = variants(base, 0, gpu.has_64_bit_atomics());
        Ok(Self {
            scene: streamer.info().name.clone(),
            described: Described::new(size.0, views.len(), repeats, base),
            tallies: variants.iter().map(|_| Tally::default()).collect(),
            gpu,
            source,
            gpu_memory,
            views,
            exact: Vec::new(),
            variants,
            base,
            repeats,
        })
    }

    /// Measures every view by every variant. Those that are fed alike take turns on one
    /// renderer, so that a busy moment of the machine hits all of them; the renderers follow each
    /// other, because a machine may not hold several.
    pub(super) async fn run(&mut self, context: &Context) -> Result<(), Exit> {
        let renderings = self.views.len() * self.repeats * self.variants.len();
        let stage = context.console.stage("measure", renderings as u64, Counted::Images);
        let rigs = self.variants.iter().map(|variant| variant.settings.rigs).max().unwrap_or(1);
        // The first variant is the most exact one: its feed comes first.
        let feeds: BTreeMap<Feed, Settings> =
            self.variants.iter().rev().map(|variant| (variant.feed, variant.settings)).collect();
        for (feed, settings) in feeds {
            let mut fed =
                Fed::new(feed, &self.source, &self.gpu, settings, self.gpu_memory).await?;
            for (number, view) in self.views.clone().iter().enumerate() {
                fed.fetch(view, rigs, context).await?;
                if number == self.exact.len() {
                    let exact = tokio::task::block_in_place(|| self.most_exact(&mut fed, view))?;
                    let points = exact.frame.stats.points_drawn;
                    self.variants = variants(self.base, points, self.gpu.has_64_bit_atomics());
                    self.exact.push(exact);
                }
                for repeat in 0..self.repeats {
                    for index in 0..self.variants.len() {
                        // Rendering waits for nothing that would notice.
                        if context.cancel.is_cancelled() {
                            return Err(Exit::Interrupted);
                        }
                        if self.variants.get(index).is_some_and(|variant| variant.feed == feed) {
                            let compared = (repeat == 0).then_some(number);
                            let measure = || self.measure(&mut fed, index, view, compared);
                            tokio::task::block_in_place(measure)?;
                            stage.advance(1);
                        }
                    }
                    // Other tasks, Ctrl-C among them, have their turn.
                    tokio::task::yield_now().await;
                }
            }
        }
        Ok(())
    }

    /// What is said of it.
    pub(super) fn report(self) -> Report {
        let mut rows = Vec::new();
        for (variant, tally) in self.variants.iter().zip(&self.tallies) {
            rows.extend(tally.rows(variant));
        }
        Report::mark_front(&mut rows);
        Report {
            scene: self.scene,
            adapter: self.gpu.adapter_name().to_owned(),
            software: self.gpu.is_software(),
            cpus: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            described: self.described,
            linearity: linearity(&self.variants, &self.tallies),
            rows,
        }
    }

    /// The most exact frame of a view.
    fn most_exact(&self, fed: &mut Fed, view: &View) -> Result<Exact, Exit> {
        let variant = self.variants.first();
        let variant = variant.ok_or_else(|| Exit::failed(anyhow::anyhow!("nothing to compare")))?;
        let Measured { frame, .. } = fed.measure(view, variant.settings)?;
        Ok(Exact { frame, depths: fed.depths()? })
    }

    /// Measures a view by the variant `index`, and where it is `compared`, which is the view's
    /// number, its errors, too.
    fn measure(
        &mut self,
        fed: &mut Fed,
        index: usize,
        view: &View,
        compared: Option<usize>,
    ) -> Result<(), Exit> {
        let (Some(variant), Some(tally)) = (self.variants.get(index), self.tallies.get_mut(index))
        else {
            return Ok(());
        };
        let Measured { frame, frame_ms, first, mut passes } =
            fed.measure(view, variant.settings)?;
        // In a frame like the one before it depth maps take nothing: what counts is to draw them.
        for (pass, first) in passes.iter_mut().zip(first) {
            if pass.pass == DEPTH_MAPS {
                *pass = first;
            }
        }
        tally.add_times(frame_ms, &passes);
        if let Some(exact) = compared.and_then(|number| self.exact.get(number)) {
            tally.stats.push(frame.stats);
            tally.difference.add_colours(&frame.rgba, &exact.frame.rgba);
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
/// Passes whose result is geometry.
const GEOMETRY: [&str; 3] = ["mesh", "points", "surface"];

/// What variants are compared with.
struct Exact {
    frame: flaneur_renderer::Frame,
    depths: Vec<Option<f32>>,
}

impl Tally {
    fn add_times(&mut self, frame_ms: f64, passes: &[PassTime]) {
        let passes = passes.iter().map(|pass| (pass.pass, pass.time.as_secs_f64() * 1e3));
        for (pass, ms) in std::iter::once((Row::FRAME, frame_ms)).chain(passes) {
            match self.times.iter_mut().find(|(name, _)| *name == pass) {
                Some((_, times)) => times.push(ms),
                None => self.times.push((pass, vec![ms])),
            }
        }
    }

    fn median_ms(&self, pass: &str) -> Option<f64> {
        let (_, times) = self.times.iter().find(|(name, _)| *name == pass)?;
        median(times)
    }

    fn rows(&self, variant: &Variant) -> impl Iterator<Item = Row> {
        let counts = Inputs::mean(&self.stats);
        self.times.iter().filter_map(move |(pass, times)| {
            let (error, error_unit) = if GEOMETRY.contains(pass) {
                (self.difference.depths_m(), Unit::Metres)
            } else {
                (self.difference.colours_255(), Unit::Colour)
            };
            let [error_max, error_p99] = error.unwrap_or([f64::NAN; 2]);
            Some(Row {
                pass,
                method: variant.method,
                setting: variant.setting.clone(),
                ms_median: median(times)?,
                ms_p95: percentile(times, 0.95)?,
                error_max,
                error_p99,
                error_unit,
                unmatched: self.difference.unmatched_share(),
                inputs: counts.to_string(),
                counts,
                front: false,
            })
        })
    }
}

/// How the points pass grows with points, the photographs pass with photographs, and the frame with
/// what it does not show.
fn linearity(variants: &[Variant], tallies: &[Tally]) -> Linearity {
    let all = || variants.iter().zip(tallies);
    let costs = |method: &'static str, pass: &str, amount: fn(&Inputs) -> f64| -> Vec<Cost> {
        all()
            .filter(|(variant, _)| variant.method == method || variant.method == "most exact")
            .filter_map(|(variant, tally)| {
                let setting = variant.to_string();
                let amount = amount(&Inputs::mean(&tally.stats));
                Some(Cost { setting, amount, ms: tally.median_ms(pass)? })
            })
            .collect()
    };
    let points = costs("points", "points", |inputs| inputs.points_drawn);
    let textures = costs("rigs", "photographs", |inputs| inputs.images_drawn);
    let off_screen = all().filter(|(variant, _)| variant.method == "default");
    let off_screen = off_screen.filter_map(|(variant, tally)| {
        let resident = match variant.feed {
            Feed::AndBehind => "what lies behind the eye, too",
            _ => "what the view wants",
        };
        let inputs = Inputs::mean(&tally.stats);
        Some(OffScreen { resident, inputs, ms: tally.median_ms(Row::FRAME)? })
    });
    Linearity {
        points_line: line_through(&points),
        textures_line: line_through(&textures),
        off_screen: off_screen.collect(),
        points,
        textures,
    }
}

//! `flaneur render`: views of a scene as pictures.

mod picture;
mod report;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::{ArgGroup, Args};
use flaneur_renderer::{
    BudgetStanding, Frame, FrameBudget, Gpu, Mode, Renderer, Settings, SplatNormals, Texturing,
};
use flaneur_scene::{SceneInfo, View};
use flaneur_services::ingest::{Progress, Unit};
use flaneur_streamer::{Event, FetchLimits, Streamer, ViewRequest};
use futures::StreamExt;

use super::Context;
use crate::atomic_file;
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::names::{Names, Pattern};
use crate::payload_cache::PayloadCache;
use crate::source::{Source, note, stream_exit};
use crate::viewpoints::{
    Height, Size, Viewpoint, parse_budget, parse_fov, parse_height, read_path, view_like,
};
use picture::format_of;
use report::{FrameReport, Report};

/// Frames that are rendered for a view, at most, to find out what holds a budget.
const MAX_TRIALS: u32 = 40;
/// Size of a picture where nothing else decides it.
const DEFAULT_SIZE: Size = Size(glam::UVec2::new(1024, 512));

/// SOURCE comes first, because --without takes as many names as follow it.
const USAGE: &str = "\
flaneur render <SOURCE> <--view …|--like …|--path …>
                      --out <FILE> [OPTIONS]";

const EXAMPLES: &str = "\
Examples:
  flaneur render scenes/paris --view 651190,6861340,43,180,5 -o frame.png
  flaneur render scenes/paris --like 490/301 --without 490 -o like.png
  flaneur render scenes/paris --view 651190,6861340,43,180,5 \\
    --mode sources -o sources.png
  flaneur render scenes/paris --view 651190,6861340,140,0,-90 \\
    --orthographic 80 -o plan.png
  flaneur render http://127.0.0.1:7878/paris --path walk.json \\
    -o walk.png --report walk.report.json

VIEWS.json is a list of views; those of the last example become walk_0001.png, walk_0002.png, …:
  [{\"position\": [651190, 6861340, 43],
    \"heading_deg\": 180, \"pitch_deg\": 5, \"fov_deg\": 60}]";

/// Arguments of `flaneur render`.
#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = USAGE)]
#[command(group = ArgGroup::new("views").required(true).args(["view", "like", "path"]))]
pub(crate) struct RenderArguments {
    /// Scene: a store's folder or URL with the scene's name at its end, or
    /// http://host:port/scene; the name may be left out where there is only one. Of several servers with
    /// commas between them another is asked where one fails
    #[arg(value_name = "SOURCE")]
    source: String,
    /// Where to stand and look: world CRS in metres, degrees clockwise from grid north, degrees
    /// up
    #[arg(long, value_name = "X,Y,Z,HEADING,PITCH", allow_hyphen_values = true)]
    view: Option<Viewpoint>,
    /// Render what the camera of this photograph sees: PANORAMA/CAMERA, or the panorama alone or
    /// its file's name if it has one camera (`flaneur info SOURCE --json` lists the ids)
    #[arg(long, value_name = "IMAGE_ID")]
    like: Option<String>,
    /// Render every view of a JSON file, into numbered files
    #[arg(long, value_name = "VIEWS.json")]
    path: Option<PathBuf>,
    /// Vertical field of view in degrees
    #[arg(long, default_value = "60", value_parser = parse_fov, conflicts_with = "like")]
    fov: f64,
    /// No perspective: show this many metres from bottom to top, of what lies before the plane
    /// through the position. No depths are inferred then, photographs are not aligned, and points are
    /// textured by the deferred way
    #[arg(long, value_name = "METRES", value_parser = parse_height, conflicts_with_all = ["like", "fov"])]
    orthographic: Option<f64>,
    /// What to show: hybrid, mesh, points, points-colour, wireframe, depth, normals, sources (which
    /// photographs) or uncertainty
    #[arg(long, default_value = "hybrid")]
    mode: Mode,
    /// How points are textured: deferred, homography or barycentric. The last two differ in time,
    /// and leave the alignment of neighbouring photographs out
    #[arg(long, default_value = "deferred")]
    texturing: Texturing,
    /// Which way points face: eye, or estimated, along the normals of their neighbours
    #[arg(long, value_name = "WAY", default_value = "eye")]
    splat_normals: SplatNormals,
    /// Size of the picture in pixels [default: that of the --like photograph or of the view in
    /// the file, else 1024x512]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Leave out photographs: ids, panoramas, or globs over either
    #[arg(long, value_name = "IMAGE_ID", num_args = 1.., value_parser = Pattern::parse)]
    without: Vec<Pattern>,
    /// Choose settings so that a frame takes about so many milliseconds on this machine: on the front
    /// of those that `flaneur bench` found nothing to beat, between its measured rungs, and below it
    /// with fewer points and pixels. Pictures then depend on the machine. Where the budget cannot be
    /// held a warning says so, and the report
    #[arg(long, value_name = "MS", value_parser = parse_budget)]
    budget_ms: Option<Duration>,
    #[command(flatten)]
    gpu_memory: GpuMemory,
    #[command(flatten)]
    cache: PayloadCache,
    /// The picture: .png, .jpg or .webp
    #[arg(short, long = "out", value_name = "FILE")]
    out: PathBuf,
    /// Write what was rendered, and how fast, as JSON
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
}

/// Renders every view that is asked for.
pub(crate) async fn run(arguments: RenderArguments, context: &Context) -> Result<(), Exit> {
    let started = Instant::now();
    let format = format_of(&arguments.out)?;
    for file in [Some(&arguments.out), arguments.report.as_ref()].into_iter().flatten() {
        atomic_file::check_folder(file)?;
    }
    let viewpoints: Vec<Viewpoint> = match (&arguments.path, arguments.view) {
        (Some(path), _) => read_path(path)?.into_iter().map(|listed| listed.viewpoint).collect(),
        (None, view) => view.into_iter().collect(),
    };
    let (mut streamer, views, gpu) = tokio::select! {
        () = context.cancel.cancelled() => return Err(Exit::Interrupted),
        ready = prepare(&arguments, &viewpoints) => ready?,
    };
    let settings = Settings {
        texturing: arguments.texturing,
        splat_normals: arguments.splat_normals,
        gpu_memory_bytes: arguments.gpu_memory.bytes(),
        ..Settings::default()
    };
    let mut session = Session {
        renderer: Renderer::with_settings(&gpu, settings),
        adapter: gpu.adapter_name().to_owned(),
        mode: arguments.mode,
        base: settings,
        budget: arguments.budget_ms.map(FrameBudget::new),
        timed: arguments.report.is_some(),
        started,
        frames: Vec::new(),
    };
    for (index, view) in views.iter().enumerate() {
        let file = match &arguments.path {
            Some(_) => numbered(&arguments.out, index + 1),
            None => arguments.out.clone(),
        };
        fetch(&mut streamer, &mut session.renderer, view, &arguments, context).await?;
        let bytes_received = streamer.statistics().bytes_received;
        let frame = session.render(view, &file, bytes_received)?;
        let encoded =
            tokio::task::block_in_place(|| format.encode(&frame)).map_err(Exit::failed)?;
        atomic_file::write(&file, &encoded)?;
        if context.cancel.is_cancelled() {
            return Err(Exit::Interrupted);
        }
    }
    streamer.flush().await;
    if let (Some(file), Some(report)) = (&arguments.report, session.report()) {
        let mut json = serde_json::to_vec_pretty(&report)?;
        json.push(b'\n');
        atomic_file::write(file, &json)?;
    }
    Ok(())
}

/// Connects, opens the graphics device meanwhile, and finds the views out.
async fn prepare(
    arguments: &RenderArguments,
    viewpoints: &[Viewpoint],
) -> Result<(Streamer, Vec<View>, Gpu), Exit> {
    let gpu = tokio::task::spawn_blocking(Gpu::new);
    let source = Source::open(&arguments.source).await?;
    let streamer = source.streamer_with(arguments.cache.options()).await?;
    let height = arguments.orthographic.map_or(Height::Degrees(arguments.fov), Height::Metres);
    let mut views: Vec<View> = viewpoints
        .iter()
        .map(|viewpoint| viewpoint.view(height, arguments.size, DEFAULT_SIZE))
        .collect();
    if arguments.like.is_some() || !arguments.without.is_empty() {
        let names = Names::all(streamer.client()).await?;
        for pattern in &arguments.without {
            names.check(pattern)?;
        }
        if let Some(like) = &arguments.like {
            views.push(view_like(names.camera(like)?, arguments.size));
        }
    }
    Ok((streamer, views, gpu.await??))
}

/// Brings everything that the view wants to the renderer.
async fn fetch(
    streamer: &mut Streamer,
    renderer: &mut Renderer,
    view: &View,
    arguments: &RenderArguments,
    context: &Context,
) -> Result<(), Exit> {
    renderer.expect_eye(view.eye());
    warn_if_far(streamer.info(), view);
    let without = arguments.without.clone();
    let request = ViewRequest {
        excluded: Arc::new(move |id| without.iter().any(|pattern| pattern.matches(id))),
        limits: arguments.gpu_memory.fitted(FetchLimits::default()),
        normals: renderer.settings().splat_normals == SplatNormals::Estimated,
        ..ViewRequest::new(*view)
    };
    let mut events = streamer.stream(request, &context.cancel);
    let (mut stage, mut remaining) = (None, 0);
    while let Some(event) = events.next().await {
        match event.map_err(stream_exit)? {
            // Uploading takes the processor for a while; other tasks go elsewhere.
            Event::Update(update) => {
                let applied = tokio::task::block_in_place(|| renderer.apply(update))?;
                note(&mut events, &applied);
            }
            Event::Progress(progress) => {
                if stage.is_none() && progress.remaining > 0 {
                    remaining = progress.remaining;
                    stage = Some(context.console.stage("fetch", remaining, Unit::Items));
                }
                if let Some(stage) = &stage {
                    stage.advance(remaining.saturating_sub(progress.remaining));
                }
                remaining = progress.remaining;
            }
            Event::Fault { error, .. } => return Err(stream_exit(error)),
        }
    }
    Ok(())
}

/// Says so where a view stands so far outside of the scene that next to nothing of it is fetched.
fn warn_if_far(scene: &SceneInfo, view: &View) {
    let (outside_m, reach_m) =
        (scene.bounds.distance(view.eye()), FetchLimits::default().point_radius_m);
    if outside_m > reach_m {
        tracing::warn!(
            "the view stands {outside_m:.0} m outside of the scene {:?}; points and photographs are \
             shown up to {reach_m:.0} m away: check the order of its coordinates, and their CRS",
            scene.name
        );
    }
}

/// One renderer and what it has done.
struct Session {
    renderer: Renderer,
    adapter: String,
    mode: Mode,
    base: Settings,
    budget: Option<FrameBudget>,
    /// Whether someone wants to know how long a frame takes.
    timed: bool,
    started: Instant,
    frames: Vec<FrameReport>,
}

impl Session {
    fn render(&mut self, view: &View, file: &Path, bytes_received: u64) -> Result<Frame, Exit> {
        tokio::task::block_in_place(|| {
            let mut standing = None;
            if let Some(budget) = &mut self.budget {
                standing = hold(budget, &mut self.renderer, self.base, view, self.mode)?;
            }
            if let Some(standing) = standing.filter(|standing| !standing.held) {
                warn_of(&standing, file);
            }
            // Each view is a picture of its own, whatever was rendered before it.
            self.renderer.cut();
            let frame = self.renderer.render_as(view, self.mode)?;
            if self.timed {
                let since_start_ms = milliseconds(self.started);
                // The first time pipelines are made and depth maps drawn: once more.
                let warm = Instant::now();
                self.renderer.render_as(view, self.mode)?;
                let frame_ms = milliseconds(warm);
                let (_, passes) = self.renderer.render_timed(view, self.mode)?;
                self.frames.push(FrameReport::new(
                    file,
                    &frame,
                    frame_ms,
                    &passes,
                    since_start_ms,
                    bytes_received,
                    &self.renderer,
                    standing,
                ));
            }
            Ok(frame)
        })
    }

    fn report(self) -> Option<Report> {
        Report::new(self.adapter, self.frames)
    }
}

/// Says that a budget cannot be held.
fn warn_of(standing: &BudgetStanding, file: &Path) {
    tracing::warn!(
        "a frame takes {:.1} ms with the cheapest settings that fit, {:.1} were asked for: render \
         a smaller picture, or allow more: {}",
        standing.reached.as_secs_f64() * 1e3,
        standing.asked.as_secs_f64() * 1e3,
        file.display()
    );
}

/// Renders `view` until a rung of the budget holds, or nothing more can be done for it. How the
/// budget fares then, if it came to rest.
fn hold(
    budget: &mut FrameBudget,
    renderer: &mut Renderer,
    base: Settings,
    view: &View,
    mode: Mode,
) -> Result<Option<BudgetStanding>, Exit> {
    let base = FrameBudget::most_exact(base);
    renderer.set_settings(budget.settings(base));
    // What is new is brought to the device, and depth maps are drawn: that is not the view's time.
    renderer.render_as(view, mode)?;
    for _ in 0..MAX_TRIALS {
        let started = Instant::now();
        renderer.render_as(view, mode)?;
        if budget.observe(started.elapsed()) {
            renderer.set_settings(budget.settings(base));
        } else if budget.is_settled() {
            break;
        }
    }
    Ok(budget.standing())
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// `frame.png` as `frame_0001.png`.
fn numbered(out: &Path, number: usize) -> PathBuf {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    let extension = out.extension().unwrap_or_default().to_string_lossy();
    out.with_file_name(format!("{stem}_{number:04}.{extension}"))
}

//! `flaneur view`: a scene in a window, to walk about in.

mod astray;
mod buildings;
mod ground;
mod measurement;
mod measuring;
mod opened;
mod painter;
mod photograph;
mod place;
mod pose;
mod start;
mod surroundings;
mod visitor;
mod window;

use std::time::{Duration, Instant};

use clap::Args;
use flaneur_renderer::{Gpu, Mode, Settings};
use flaneur_streamer::FetchLimits;
use glam::UVec2;

use super::Context;
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::payload_cache::PayloadCache;
use crate::viewpoints::{Size, Viewpoint, parse_budget, parse_fov};
use opened::Opened;
use painter::{PaintOptions, Painter};
use pose::Pose;
use surroundings::Surroundings;
use visitor::Visitor;
use window::{App, Scene, Told};

/// Size of the window where nobody asks for another.
const DEFAULT_SIZE: Size = Size(UVec2::new(1280, 720));

const EXAMPLES: &str = "\
Examples:
  flaneur view scenes/paris
  flaneur view scenes/paris/scene.json
  flaneur view http://127.0.0.1:7878/paris --cache ~/.cache/flaneur
  flaneur view scenes/paris --view 651190,6861340,43,180,5 \\
    --fov 75 --size 1600x900

The controls are those of the web page. Drag to look, turn the wheel to zoom, walk with W, A, S, D or \
the arrows; click the ground to go there, a wall to face it, twice to go to the nearest photograph. \
M measures, ? or H shows all keys, O the figures.";

/// Arguments of `flaneur view`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ViewArguments {
    /// Scene: a store's folder or URL with the scene's name at its end, its scene.json, or
    /// http://host:port/scene; the name may be left out where there is only one. Of several servers with
    /// commas between them another is asked where one fails
    #[arg(value_name = "SOURCE")]
    source: String,
    /// Where to stand and look at first: world CRS in metres, degrees clockwise from grid north, degrees
    /// up [default: at the photograph nearest to the scene's middle, or in the open where there are none]
    #[arg(long, value_name = "X,Y,Z,HEADING,PITCH", allow_hyphen_values = true)]
    view: Option<Viewpoint>,
    /// Vertical field of view in degrees, at first
    #[arg(long, default_value = "60", value_parser = parse_fov)]
    fov: f64,
    /// What to show at first; the keys 1 to 9 change it: hybrid, mesh, points, sources (which
    /// photographs), uncertainty, points-colour, wireframe, depth or normals
    #[arg(long, default_value = "hybrid")]
    mode: Mode,
    /// Size of the window in pixels, at first [default: 1280x720]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// While one moves, choose settings so that a frame takes about so many milliseconds on this machine.
    /// Who stands gets the best there is, however long it takes
    #[arg(long, value_name = "MS", default_value = "80", value_parser = parse_budget)]
    budget_ms: Duration,
    #[command(flatten)]
    gpu_memory: GpuMemory,
    #[command(flatten)]
    cache: PayloadCache,
}

/// Shows the scene until the window is closed.
pub(crate) async fn run(arguments: ViewArguments, context: &Context) -> Result<(), Exit> {
    let Size(size) = arguments.size.unwrap_or(DEFAULT_SIZE);
    let stream_options = arguments.cache.options();
    let fov_y = arguments.fov.to_radians();
    // What was typed comes first: whoever mends the display does not want to hear of it then.
    let mut opened = tokio::select! {
        () = context.cancel.cancelled() => return Err(Exit::Interrupted),
        opened = Opened::open(&arguments.source, stream_options.clone(), fov_y) => opened?,
    };
    let event_loop = window::event_loop()?;
    let proxy = event_loop.create_proxy();
    let gpu = tokio::task::spawn_blocking(Gpu::new).await??;
    let scene = Scene::of(&opened);
    if let Some(viewpoint) = arguments.view {
        let (heading, pitch) = viewpoint.angles();
        opened.start = Pose::new(viewpoint.eye(), heading, pitch, fov_y);
    }
    let options = PaintOptions {
        settings: Settings {
            gpu_memory_bytes: arguments.gpu_memory.bytes(),
            ..Settings::default()
        },
        limits: arguments.gpu_memory.fitted(FetchLimits::default()),
        budget: arguments.budget_ms,
    };
    let adapter = gpu.adapter_name().to_owned();
    let visitor = Visitor::new(opened.start, Instant::now());
    let told = proxy.clone();
    let painter = Painter::start(gpu, opened, options, move |news| {
        // A window that has closed is told nothing.
        drop(told.send_event(Told::Painter(news)));
    })?;
    let app = App {
        visitor,
        painter,
        surroundings: Surroundings::default(),
        scene,
        mode: arguments.mode,
        size,
        adapter,
        proxy,
        stream_options,
        open: None,
        photographs: 0,
        exit: None,
    };
    // Windows live on the main thread, and so does this.
    tokio::task::block_in_place(|| window::run(event_loop, app, context.cancel.clone()))
}

//! `flaneur walk`: what a visitor sees over a slow connection, and when.

mod feed;
mod judge;
mod kept;
mod link;
mod route;
mod stroll;
mod warm;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use flaneur_renderer::{Gpu, Renderer, Settings};
use flaneur_streamer::{FetchLimits, Order};
use tokio_util::sync::CancellationToken;

use super::Context;
use crate::atomic_file;
use crate::evaluation::StatedSettings;
use crate::evaluation::walk::{Asked, Machine, Report, Sample};
use crate::evaluation::walk_page;
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::output;
use crate::throttle::{Bandwidth, Conditions, parse_latency};
use crate::viewpoints::{Size, parse_fov, read_path};
use judge::Judge;
use kept::Kept;
use link::Link;
use route::Route;
use stroll::{STAND, Stroll, Walked};

/// The smallest side of a picture: a window of SSIM.
const LEAST_SIDE: u32 = 7;

const EXAMPLES: &str = "\
Examples:
  flaneur walk scenes/paris --path walk.json \\
    --bandwidth 10M --latency 50ms --report r.json
  flaneur walk scenes/street --path street/truth/walk.json \\
    --report r.json --html r.html
  flaneur walk http://127.0.0.1:7878/paris --path walk.json \\
    --bandwidth 2M --report r.json

VIEWS.json is that of `flaneur render --path`; its views are stops of one walk, all of the size \
given here. Each may have a \"time_s\", the seconds since connecting began at which it is \
reached; without them the walk goes straight from view to view at --speed, and turns at 90 \
degrees a second where it stands. A walk takes at most an hour. At the last view it waits until \
everything has come and the picture rests, at most 120 s.

The connection: a store is served on a free port of this machine; it, or the server given, is \
reached through a proxy in this process, by TCP and HTTP/2. Bandwidth and latency hold each way, \
so that an answer takes twice the latency at least, and so does setting the connection up. Loss, \
slow start and TLS are not modelled.

Time zero is when connecting begins. Before it the graphics device is opened, and the first view \
is loaded past the proxy and drawn, so that every shader is compiled; nothing of it is kept, but \
by the server and the system, which may have it in memory. The first picture is the first frame \
after the base mesh within 120 m and a coarse level of the photographs that decide nine tenths of \
the picture have come; before, nothing is drawn. A \
frame is kept every 0.1 s at first, every twentieth of the time that has passed, and at least \
every second, in the system's temporary folder. After the walk, past the proxy, each is compared \
with the frame of the same view with everything it wants: ms_to_ssim_090 and ms_to_ssim_095 are \
when the first of them had that SSIM, of the view of that moment. SSIM and PSNR are those of \
`flaneur eval`, over the whole picture.

Ctrl-C ends the walk; what was seen until then is compared and written. A second one ends that.";

/// Arguments of `flaneur walk`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct WalkArguments {
    /// Scene: a store's folder or URL with the scene's name at its end, or
    /// http://host:port/scene; the name may be left out where there is only one
    #[arg(value_name = "SOURCE")]
    source: String,
    /// Where to walk
    #[arg(long, value_name = "VIEWS.json")]
    path: PathBuf,
    /// Bits a second, each way, as in 10M or 500k; or unlimited
    #[arg(long, value_name = "RATE", default_value = "unlimited")]
    bandwidth: Bandwidth,
    /// How much later everything arrives, each way, as in 50ms
    #[arg(long, value_name = "TIME", default_value = "0", value_parser = parse_latency)]
    latency: Duration,
    /// How fast to walk between views without times, metres a second
    #[arg(long, value_name = "M/S", default_value = "1.4", value_parser = parse_speed)]
    speed: f64,
    /// What is fetched first: what lowers the expected error of the picture most a byte, or what is
    /// nearest
    #[arg(long, value_enum, default_value_t = OrderName::ExpectedError)]
    order: OrderName,
    /// Vertical field of view in degrees, of views without one
    #[arg(long, default_value = "60", value_parser = parse_fov)]
    fov: f64,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x512", value_parser = parse_size)]
    size: Size,
    #[command(flatten)]
    gpu_memory: GpuMemory,
    /// Every figure, as JSON
    #[arg(long, value_name = "FILE.json")]
    report: PathBuf,
    /// The figures, and quality against bytes and time, as one page
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
}

/// An [`Order`] by its name.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum OrderName {
    ExpectedError,
    NearestFirst,
}

impl From<OrderName> for Order {
    fn from(name: OrderName) -> Self {
        match name {
            OrderName::ExpectedError => Self::ExpectedError,
            OrderName::NearestFirst => Self::NearestFirst,
        }
    }
}

/// Walks, compares, writes the report, prints the figures.
pub(crate) async fn run(arguments: WalkArguments, context: &Context) -> Result<(), Exit> {
    for file in [Some(&arguments.report), arguments.html.as_ref()].into_iter().flatten() {
        atomic_file::check_folder(file)?;
    }
    let listed = read_path(&arguments.path)?;
    let route = Route::new(&listed, arguments.speed, arguments.fov, arguments.size);
    let route = route.map_err(|problem| {
        Exit::bad_input(anyhow::anyhow!("{}: {problem}", arguments.path.display()))
    })?;
    let settings =
        Settings { gpu_memory_bytes: arguments.gpu_memory.bytes(), ..Settings::default() };
    let limits = arguments.gpu_memory.fitted(FetchLimits::default());
    let conditions = Conditions { bandwidth: arguments.bandwidth, latency: arguments.latency };

    let prepare = async {
        let gpu = tokio::task::spawn_blocking(Gpu::new);
        let link = Link::open(&arguments.source, conditions).await?;
        let gpu = gpu.await??;
        let mut renderer = Renderer::with_settings(&gpu, settings);
        let (direct, first) = (link.direct().await?, route.view(0.0));
        warm::warm_up(&mut renderer, &direct, &first, limits, &context.cancel).await?;
        Ok::<_, Exit>((link, gpu, renderer))
    };
    let (link, gpu, renderer) = tokio::select! {
        () = context.cancel.cancelled() => return Err(Exit::Interrupted),
        prepared = prepare => prepared?,
    };
    let mut stroll = Stroll::new(&route, limits, renderer, Kept::new()?);
    let mut outcome = stroll.walk(&link, arguments.order.into(), context).await;
    let mut walked = stroll.into_walked();
    let [down, up] = link.carried();
    (walked.profile.tcp_bytes_down, walked.profile.tcp_bytes_up) = (down, up);

    let mut samples = Vec::new();
    if !walked.kept.frames().is_empty() {
        // Once the walk is interrupted it takes a second signal to stop this.
        let cancel = match &outcome {
            Err(Exit::Interrupted) => CancellationToken::new(),
            _ => context.cancel.child_token(),
        };
        let judged = async {
            let direct = link.direct().await?;
            let mut judge = Judge::new(&direct, &gpu, settings, limits, cancel).await?;
            judge.judge(&mut walked.kept, &mut samples, &context.console).await
        };
        outcome = outcome.and(judged.await);
    }
    if outcome.is_ok() && !walked.whole {
        tracing::warn!(
            "not everything that the last view wants had come {} s after it was reached: the samples \
             end before the best picture",
            STAND.as_secs()
        );
    }
    let report = report(&arguments, &route, &link, &gpu, settings, walked, samples);
    if let Some(file) = &arguments.html {
        atomic_file::write(file, walk_page(&report).as_bytes())?;
    }
    let mut json = serde_json::to_vec_pretty(&report)?;
    json.push(b'\n');
    atomic_file::write(&arguments.report, &json)?;
    output::print(&summary(&report))?;
    outcome
}

fn report(
    arguments: &WalkArguments,
    route: &Route,
    link: &Link,
    gpu: &Gpu,
    settings: Settings,
    walked: Walked,
    samples: Vec<Sample>,
) -> Report {
    let Size(size) = arguments.size;
    let passed = walked.statistics;
    let looked_up = passed.cache_hits + passed.cache_misses;
    let carried = walked.profile.tcp_bytes_down.max(passed.bytes_received);
    Report {
        first_picture_ms: walked.first_picture.map(|shown| shown.ms),
        first_picture_bytes: walked.first_picture_bytes,
        ms_to_ssim_090: Sample::reached(&samples, 0.90),
        ms_to_ssim_095: Sample::reached(&samples, 0.95),
        bytes: carried,
        // What was cut off within a message no message tells of.
        bytes_wasted: passed.bytes_wasted + carried.saturating_sub(passed.bytes_received),
        cache_hit_rate: passed.cache_hits as f64 / looked_up.max(1) as f64,
        requests: passed.requests,
        cancelled: passed.cancelled,
        longest_frame_ms: walked.longest_frame_ms,
        samples,
        settings: Asked {
            scene: link.scene().to_owned(),
            bandwidth_bits_per_s: arguments.bandwidth.bits_per_second(),
            latency_ms: arguments.latency.as_secs_f64() * 1e3,
            walk_s: route.end_s(),
            width: size.x,
            height: size.y,
            renderer: StatedSettings(settings),
        },
        machine: Machine {
            adapter: gpu.adapter_name().to_owned(),
            software: gpu.is_software(),
            cpus: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        },
        profile: walked.profile,
    }
}

/// The figures, a line each.
fn summary(report: &Report) -> String {
    let seconds =
        |ms: Option<f64>| ms.map_or("never".to_owned(), |ms| format!("after {:.2} s", ms / 1e3));
    let kilobytes = |bytes: u64| format!("{:.0} kB", bytes as f64 / 1e3);
    let first = report
        .first_picture_bytes
        .map_or(String::new(), |bytes| format!(" and {}", kilobytes(bytes)));
    let wasted = 100.0 * report.bytes_wasted as f64 / report.bytes.max(1) as f64;
    format!(
        "first picture    {}{first}\nSSIM 0.90        {}\nSSIM 0.95        {}\nreceived         \
         {}, {wasted:.1} % of them wasted; {} requests, {} cancelled\nlongest frame    {:.0} ms, {} frames compared\n",
        seconds(report.first_picture_ms),
        seconds(report.ms_to_ssim_090),
        seconds(report.ms_to_ssim_095),
        kilobytes(report.bytes),
        report.requests,
        report.cancelled,
        report.longest_frame_ms.unwrap_or(0.0),
        report.samples.len(),
    )
}

/// A speed in metres a second.
fn parse_speed(text: &str) -> Result<f64, String> {
    let speed: f64 = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    if (0.01..=100.0).contains(&speed) {
        Ok(speed)
    } else {
        Err(format!("the speed is {speed}, must be 0.01 to 100 metres a second"))
    }
}

/// A size that SSIM is defined for.
fn parse_size(text: &str) -> Result<Size, String> {
    let size: Size = text.parse()?;
    if size.0.min_element() >= LEAST_SIDE {
        Ok(size)
    } else {
        Err(format!("{text} pixels, must be at least {LEAST_SIDE} a side"))
    }
}

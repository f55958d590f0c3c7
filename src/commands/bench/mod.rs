//! `flaneur bench`: the time that frames take against their error.

mod exactness;
mod feed;
mod front;
mod growth;
mod path;
mod session;
mod tally;
mod views;
mod walk;

use std::path::PathBuf;

use clap::Args;

use super::Context;
use crate::atomic_file;
use crate::evaluation::speed::{Report, Row};
use crate::evaluation::speed_page;
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::output;
use crate::viewpoints::{Size, parse_fov};
use session::Session;

const EXAMPLES: &str = "\
Examples:
  flaneur bench scenes/paris --report bench.json --html bench.html
  flaneur bench scenes/karlsruhe --path walk.json --size 1920x1080 \\
    --repeats 9 --report bench.json
  flaneur bench scenes/street --report bench.json \\
    --front renderer/src/frame_budget/front.rs

The most exact frame of a run has every setting at its most exact: 16 rigs, depth maps of 1024 \
texels, all points, full resolution. Every variant changes one setting of it; its error is the \
difference of its frames to the most exact ones, over all pixels of all views: of colours as \
bytes (the largest of the three channels), of depth in metres where both show a surface. A pixel \
that no photograph colours where one should counts as a difference of 255. Variants take turns, \
view by view. `bytes` is what the renderer held on the device after the frames of a row. Rows \
`texturing` leave the alignment out: compare them with `alignment off`. A rig counts all its \
cameras: of `rigs 1` as many photographs may be drawn as one panorama has.

From what each setting does alone follows a way down from the most exact settings (rows \
`combined`); what of it nothing beats is the front that `flaneur render --budget-ms` chooses \
from. At last the view moves along the survey's way under three budgets of time (rows `budget`). \
Rows `against f64` compare a small part of the first view, away from edges of depth, with the \
reference in f64. VIEWS.json is that of `flaneur render --path`.";

/// Arguments of `flaneur bench`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct BenchArguments {
    /// Scene: a store's folder or URL with the scene's name at its end, or
    /// http://host:port/scene; the name may be left out where there is only one
    #[arg(value_name = "SOURCE")]
    source: String,
    /// Every figure, as JSON
    #[arg(long, value_name = "FILE.json")]
    report: PathBuf,
    /// Tables, and the plot of time against error, as one page
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    /// The front of frames, as the table that the renderer's frame budget is compiled with
    #[arg(long, value_name = "FILE.rs")]
    front: Option<PathBuf>,
    /// Measure the views of this file [default: two near photographs of the scene]
    #[arg(long, value_name = "VIEWS.json")]
    path: Option<PathBuf>,
    /// Vertical field of view in degrees
    #[arg(long, default_value = "60", value_parser = parse_fov)]
    fov: f64,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x512")]
    size: Size,
    #[command(flatten)]
    gpu_memory: GpuMemory,
    /// How often each view is rendered by each variant; once where that takes more than 2 s
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,
}

/// Measures, writes the report, prints the frames' rows.
pub(crate) async fn run(arguments: BenchArguments, context: &Context) -> Result<(), Exit> {
    let files = [Some(&arguments.report), arguments.html.as_ref(), arguments.front.as_ref()];
    for file in files.into_iter().flatten() {
        atomic_file::check_folder(file)?;
    }
    let measure = async {
        let mut session = Session::prepare(&arguments).await?;
        session.run(context).await?;
        Ok::<_, Exit>(session.report())
    };
    let report = tokio::select! {
        () = context.cancel.cancelled() => return Err(Exit::Interrupted),
        measured = measure => measured?,
    };
    if let Some(file) = &arguments.html {
        atomic_file::write(file, speed_page(&report).as_bytes())?;
    }
    if let Some(file) = &arguments.front {
        front::write(file, &report)?;
    }
    let mut json = serde_json::to_vec_pretty(&report)?;
    json.push(b'\n');
    atomic_file::write(&arguments.report, &json)?;
    output::print(&summary(&report))
}

/// The frames' rows as a table.
fn summary(report: &Report) -> String {
    let mut lines = vec![format!(
        "{:48}{:>9}{:>9}{:>11}{:>11}{:>11}  inputs",
        "method", "ms", "ms p95", "rms 1/255", "99 % 1/255", "max 1/255"
    )];
    lines.extend(report.frames().map(|row| {
        let within = row
            .within_fifth
            .map_or(String::new(), |share| format!("  {:.0} % within a fifth", 100.0 * share));
        format!(
            "{:48}{:9.1}{:9.1}{:11.2}{:11.0}{:11.0}  {}{}{within}",
            Row::label(row.method, &row.setting),
            row.ms_median,
            row.ms_p95,
            row.error_rms,
            row.error_p99,
            row.error_max,
            row.inputs,
            if row.front { "  *" } else { "" },
        )
    }));
    let described = &report.described;
    lines.push(format!(
        "* on the front. {}x{}, {} views, {} repeats, {}, {} processor cores\n",
        described.width,
        described.height,
        described.views,
        described.repeats,
        report.adapter,
        report.cpus
    ));
    lines.join("\n")
}

//! `flaneur ingest`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use flaneur_services::ingest::street::Street;
use flaneur_services::ingest::{IngestError, IngestOptions, Job, Summary, Warnings};
use flaneur_services::store::Store;

use super::Context;
use crate::exit::Exit;
use crate::memory::MemorySize;
use crate::output;

const EXAMPLES: &str = "\
Examples:
  flaneur ingest survey --out scenes            a folder with a street.toml
  flaneur ingest survey/street.toml --out s3://bucket/streets
  flaneur ingest survey --out scenes --memory 8GiB --work /scratch
  flaneur ingest survey --out scenes --json     a summary for programs

An ingest that was interrupted goes on where it stopped, and one over the same inputs does \
nothing. The scene appears in the store whole, or not at all.

Exit codes: 0 done, 2 bad input or usage, 130 interrupted, 1 anything else.";

/// Arguments of `flaneur ingest`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct IngestArguments {
    /// The survey: a folder that holds a street.toml, or that file
    #[arg(value_name = "STREET")]
    street: PathBuf,
    /// The store to publish in: a folder, or a URL such as s3://bucket/prefix
    #[arg(long, value_name = "STORE")]
    out: String,
    /// Name of the scene, instead of the one in street.toml
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Memory to stay within: bytes, or with KiB, MiB, GiB
    #[arg(long, value_name = "SIZE", default_value = "2GiB")]
    memory: MemorySize,
    /// Folder for intermediate files, which may grow larger than the survey [default: a
    /// folder in the user's cache]
    #[arg(long, value_name = "DIR")]
    work: Option<PathBuf>,
    /// Leave damaged files out with a warning instead of stopping
    #[arg(long)]
    skip_damaged: bool,
    /// Refuse paths that lead out of the survey's folder
    #[arg(long)]
    confine: bool,
    /// Make and publish everything anew, even where nothing has changed
    #[arg(long)]
    force: bool,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

/// Warnings of a kind that are printed in full.
const SHOWN_WARNINGS: usize = 50;

/// Ingests a street and prints what came of it.
pub(crate) async fn run(arguments: IngestArguments, context: &Context) -> Result<(), Exit> {
    let mut street = Street::open(&arguments.street, arguments.confine).map_err(exit)?;
    if let Some(name) = arguments.name {
        if !Street::is_name(&name) {
            return Err(Exit::bad_input(anyhow::anyhow!(
                "--name {name:?} cannot be a name; use 1 to 64 letters a-z A-Z, digits, '-', \
                 '_' and '.'"
            )));
        }
        street.scene.name = name;
    }
    let store = Store::open(&arguments.out).map_err(Exit::bad_input)?;
    let work = match arguments.work {
        Some(work) => work,
        None => default_work_folder()?,
    };
    let mut job =
        Job::new(work, arguments.memory.bytes()).showing(Arc::new(context.console.clone()));
    job.skip_damaged = arguments.skip_damaged;
    let job = Arc::new(job);

    let options = IngestOptions { force: arguments.force };
    let ingest = flaneur_services::ingest::ingest(street, store, options, Arc::clone(&job));
    let mut ingest = std::pin::pin!(ingest);
    let outcome = tokio::select! {
        outcome = &mut ingest => outcome,
        () = context.cancel.cancelled() => {
            // It stops at its next check and removes what it had put into the store.
            job.cancel();
            ingest.await
        }
    };
    let summary = outcome.map_err(exit)?;
    warn(&summary, context);
    if arguments.json { output::print_json(&summary) } else { output::print(&describe(&summary)) }
}

/// What the person gave (files, store, disk) is at fault in every case but an interruption.
fn exit(error: IngestError) -> Exit {
    match error {
        IngestError::Cancelled => Exit::Interrupted,
        error => Exit::bad_input(error),
    }
}

fn default_work_folder() -> Result<PathBuf, Exit> {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let cache = set("XDG_CACHE_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = cache.or_else(|| Some(PathBuf::from(set("HOME")?).join(".cache")));
    cache.map(|cache| cache.join("flaneur/ingest")).ok_or_else(|| {
        Exit::bad_input(anyhow::anyhow!("there is no home folder to work in; give --work DIR"))
    })
}

/// The first warnings of each kind, and how many more there are.
fn warn(summary: &Summary, context: &Context) {
    let warnings = Warnings::from_lines(&summary.warning_messages);
    for (kind, count) in &summary.warnings {
        for message in warnings.messages(kind).iter().take(SHOWN_WARNINGS) {
            context.console.line(&format!("warning: {kind}: {message}"));
        }
        if *count > SHOWN_WARNINGS as u64 {
            let more = count - SHOWN_WARNINGS as u64;
            context.console.line(&format!("warning: {kind}: and {more} more (all with --json)"));
        }
    }
}

fn describe(summary: &Summary) -> String {
    let Summary { scene, store, points, footprints, panoramas, images, .. } = summary;
    let place = format!("{}/{scene}", store.trim_end_matches('/'));
    let holds = format!(
        "{points} points, {footprints} footprints, {images} images of {panoramas} panoramas, \
         {:.1} MiB",
        mib(summary.bytes)
    );
    if summary.unchanged {
        return format!("unchanged: {place} was made from the same inputs ({holds})\n");
    }
    let mut text = format!("published {place}: {holds}\nin {:.1} s", summary.seconds);
    if summary.points_per_second > 0.0 {
        text.push_str(&format!(", {:.0} points/s", summary.points_per_second));
    }
    if let Some(peak) = summary.peak_memory_bytes {
        text.push_str(&format!(", at most {:.0} MiB of memory", mib(peak)));
    }
    if !summary.layers_reused.is_empty() {
        let layers = summary.layers_reused.join(", ");
        text.push_str(&format!("\ncontinued an earlier run, which had finished {layers}"));
    }
    text.push('\n');
    text
}

#[expect(clippy::cast_precision_loss, reason = "a figure for people")]
fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

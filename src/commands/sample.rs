//! `flaneur sample`: a synthetic street.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use clap::Args;
use flaneur_sample::{Progress as Step, SampleError, SampleOptions, Stage as Part, write_street};
use flaneur_services::ingest::{Progress, Stage, Unit};

use super::Context;
use crate::exit::Exit;
use crate::output;
use crate::progress::Console;

const EXAMPLES: &str = "\
Examples:
  flaneur sample street                         120 m, 1.5 million points
  flaneur sample street --scale 0.2 --seed 7    a small one, another street
  flaneur sample load --scale 14 \\
    --without-photographs                       about 20 million points

The folder holds a survey for `flaneur ingest`, and in truth/ views that were held out.";

/// Arguments of `flaneur sample`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct SampleArguments {
    /// Folder to write, empty or absent
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Equal seeds give equal files
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Times the street's length, photographs and points: 1 is 120 m with 1.5 million points,
    /// 0.2 to 30
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    scale: f64,
    /// Write no photographs: a load test of the points alone
    #[arg(long)]
    without_photographs: bool,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

/// Writes the street.
pub(crate) async fn run(arguments: SampleArguments, context: &Context) -> Result<(), Exit> {
    let mut options =
        SampleOptions::scaled(arguments.seed, arguments.scale).map_err(sample_exit)?;
    if arguments.without_photographs {
        options = options.without_photographs();
    }
    let cancelled = Arc::new(AtomicBool::new(false));
    let (cancel, folder) = (Arc::clone(&cancelled), arguments.folder.clone());
    let shown = Shown { console: context.console.clone(), current: Mutex::default() };
    let work = tokio::task::spawn_blocking(move || {
        write_street(&folder, &options, &|step| shown.show(step), &cancel)
    });
    let mut work = std::pin::pin!(work);
    let written = tokio::select! {
        written = &mut work => written?,
        () = context.cancel.cancelled() => {
            cancelled.store(true, Ordering::Relaxed);
            // What was begun is cleared away first.
            work.await?
        }
    };
    let summary = written.map_err(sample_exit)?;
    if arguments.json {
        return output::print_json(&summary);
    }
    output::print(&format!(
        "{} buildings, {} photographs, {} held-out views, {} points in {} files: {}\n",
        summary.buildings,
        summary.photographs,
        summary.views,
        summary.points,
        summary.point_files,
        arguments.folder.display()
    ))
}

/// What is shown of the work.
struct Shown {
    console: Console,
    current: Mutex<Option<Current>>,
}

/// The stage under way.
struct Current {
    part: Part,
    done: u64,
    stage: Box<dyn Stage>,
}

impl Shown {
    fn show(&self, step: Step) {
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        if current.as_ref().is_none_or(|current| current.part != step.stage) {
            // The stage before ends first.
            *current = None;
            let unit = match step.stage {
                Part::Photographs | Part::Views => Unit::Images,
                Part::Points => Unit::Points,
                Part::Street => Unit::Items,
            };
            let stage = self.console.stage(step.stage.name(), step.total, unit);
            *current = Some(Current { part: step.stage, done: 0, stage });
        }
        if let Some(current) = &mut *current {
            current.stage.advance(step.done.saturating_sub(current.done));
            current.done = step.done.max(current.done);
        }
    }
}

fn sample_exit(error: SampleError) -> Exit {
    match error {
        SampleError::Cancelled => Exit::Interrupted,
        SampleError::Option { .. } | SampleError::NotEmpty { .. } => Exit::bad_input(error),
        error => Exit::failed(error),
    }
}

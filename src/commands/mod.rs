//! One file a subcommand: its arguments, and what it wires together.

mod bench;
mod eval;
mod info;
mod ingest;
mod render;
mod sample;
mod serve;
mod view;
mod walk;

use clap::Subcommand;
use tokio_util::sync::CancellationToken;
use tracing::level_filters::LevelFilter;

use crate::exit::Exit;
use crate::progress::Console;

/// What `flaneur` can do.
#[derive(Subcommand)]
pub(crate) enum Command {
    /// Turn a survey's files into a scene of a store
    Ingest(ingest::IngestArguments),
    /// Serve the scenes of stores over gRPC
    Serve(serve::ServeArguments),
    /// Render views of a scene into pictures
    Render(render::RenderArguments),
    /// Walk about a scene in a window
    View(view::ViewArguments),
    /// Measure renderings against photographs that were held out
    Eval(eval::EvalArguments),
    /// Measure the time that frames take against their error
    Bench(bench::BenchArguments),
    /// Walk over a slow connection, and measure what is seen when
    Walk(walk::WalkArguments),
    /// Print what a scene holds
    Info(info::InfoArguments),
    /// Write a synthetic street in the formats of a survey
    Sample(sample::SampleArguments),
}

/// What every command is given.
pub(crate) struct Context {
    /// Cancelled at Ctrl-C or SIGTERM: stop soon and return [`Exit::Interrupted`].
    pub(crate) cancel: CancellationToken,
    /// Where progress is shown.
    pub(crate) console: Console,
}

impl Command {
    /// What is logged where nobody asks for more: a server tells its operator what it does.
    pub(crate) fn default_log_level(&self) -> LevelFilter {
        match self {
            Self::Serve(_) => LevelFilter::INFO,
            _ => LevelFilter::WARN,
        }
    }

    /// Runs the command to its end.
    pub(crate) async fn run(self, context: &Context) -> Result<(), Exit> {
        match self {
            Self::Ingest(arguments) => ingest::run(arguments, context).await,
            Self::Serve(arguments) => serve::run(arguments, context).await,
            Self::Render(arguments) => render::run(arguments, context).await,
            Self::View(arguments) => view::run(arguments, context).await,
            Self::Eval(arguments) => eval::run(arguments, context).await,
            Self::Bench(arguments) => bench::run(arguments, context).await,
            Self::Walk(arguments) => walk::run(arguments, context).await,
            Self::Info(arguments) => info::run(arguments, context).await,
            Self::Sample(arguments) => sample::run(arguments, context).await,
        }
    }
}

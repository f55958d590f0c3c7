//! `flaneur render`.

use clap::Args;

use super::Context;
use crate::exit::Exit;

/// Arguments of `flaneur render`.
#[derive(Args)]
pub(crate) struct RenderArguments {
    /// TODO
    #[arg(value_name = "SOURCE")]
    source: String,
}

/// TODO
pub(crate) async fn run(arguments: RenderArguments, _context: &Context) -> Result<(), Exit> {
    Err(Exit::failed(anyhow::anyhow!("{}: not wired yet", arguments.source)))
}

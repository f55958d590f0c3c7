//! `flaneur info`.

use clap::Args;

use super::Context;
use crate::exit::Exit;

/// Arguments of `flaneur info`.
#[derive(Args)]
pub(crate) struct InfoArguments {
    /// TODO
    #[arg(value_name = "SOURCE")]
    source: String,
}

/// TODO
pub(crate) async fn run(arguments: InfoArguments, _context: &Context) -> Result<(), Exit> {
    Err(Exit::failed(anyhow::anyhow!("{}: not wired yet", arguments.source)))
}

//! `flaneur serve`.

use clap::Args;

use super::Context;
use crate::exit::Exit;

/// Arguments of `flaneur serve`.
#[derive(Args)]
pub(crate) struct ServeArguments {
    /// TODO
    #[arg(value_name = "STORE")]
    store: String,
}

/// TODO
pub(crate) async fn run(arguments: ServeArguments, _context: &Context) -> Result<(), Exit> {
    Err(Exit::failed(anyhow::anyhow!("{}: not wired yet", arguments.store)))
}

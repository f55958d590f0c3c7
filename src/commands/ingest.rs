//! `flaneur ingest`.

use clap::Args;

use super::Context;
use crate::exit::Exit;

/// Arguments of `flaneur ingest`.
#[derive(Args)]
pub(crate) struct IngestArguments {
    /// TODO
    #[arg(value_name = "STREET")]
    street: String,
}

/// TODO
pub(crate) async fn run(arguments: IngestArguments, _context: &Context) -> Result<(), Exit> {
    Err(Exit::failed(anyhow::anyhow!("{}: not wired yet", arguments.street)))
}

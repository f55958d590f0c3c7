//! `flaneur sample`.

use clap::Args;

use super::Context;
use crate::exit::Exit;

/// Arguments of `flaneur sample`.
#[derive(Args)]
pub(crate) struct SampleArguments {
    /// TODO
    #[arg(value_name = "DIR")]
    dir: String,
}

/// TODO
pub(crate) async fn run(arguments: SampleArguments, _context: &Context) -> Result<(), Exit> {
    Err(Exit::failed(anyhow::anyhow!("{}: not wired yet", arguments.dir)))
}

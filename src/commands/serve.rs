//! `flaneur serve`.

use std::net::SocketAddr;

use clap::Args;
use flaneur_services::grpc::{Limits, ServeError, Server};
use flaneur_services::store::{Catalog, Store, StoreError};

use super::Context;
use crate::exit::Exit;
use crate::output;

const EXAMPLES: &str = "\
Examples:
  flaneur serve scenes                          every scene of a folder
  flaneur serve scenes/paris                    one scene alone
  flaneur serve scenes s3://bucket/streets      scenes of several stores
  flaneur serve scenes --listen 0.0.0.0:80      to everyone who reaches this machine

Prints one line, `serving http://ADDRESS`, once calls are answered. Scenes that are published
while it runs are found. Ctrl-C or SIGTERM ends it once the calls in flight are done; a second
one ends it at once.

Cloud stores take their settings from the environment, as in AWS_REGION, AWS_ENDPOINT,
AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY.";

/// Arguments of `flaneur serve`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ServeArguments {
    /// Folder or URL (s3://, gs://, az://) with scenes, or of one scene
    #[arg(value_name = "STORE", required = true)]
    stores: Vec<String>,
    /// Address to listen on; port 0 is any free one
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:7878")]
    listen: SocketAddr,
    /// Most calls in flight; more are refused
    #[arg(long, value_name = "N", default_value_t = Limits::default().calls)]
    max_calls: usize,
}

/// Serves the data services until Ctrl-C.
pub(crate) async fn run(arguments: ServeArguments, context: &Context) -> Result<(), Exit> {
    let stores: Result<Vec<Store>, StoreError> =
        arguments.stores.iter().map(|url| Store::open_existing(url)).collect();
    let catalog = Catalog::open(stores.map_err(of_store)?).await.map_err(of_store)?;
    let scenes = catalog.names().await.map_err(of_store)?;
    if scenes.is_empty() {
        tracing::warn!(stores = ?arguments.stores, "no scene is published there yet");
    }
    let limits = Limits { calls: arguments.max_calls, ..Limits::default() };
    let server = Server::bind(catalog, arguments.listen, limits).await.map_err(of_server)?;
    output::print(&format!("serving http://{}\n", server.address()))?;
    tracing::info!(address = %server.address(), ?scenes, "serving");
    server.serve(context.cancel.cancelled()).await.map_err(of_server)
}

/// What the person typed is at fault, or the store is.
fn of_store(error: StoreError) -> Exit {
    match error {
        StoreError::Object { .. } => Exit::failed(error),
        _ => Exit::bad_input(error),
    }
}

fn of_server(error: ServeError) -> Exit {
    match error {
        ServeError::Bind { .. } => Exit::bad_input(error),
        _ => Exit::failed(error),
    }
}

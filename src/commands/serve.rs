//! `flaneur serve`.

use std::net::SocketAddr;
use std::time::Duration;

use clap::Args;
use flaneur_renderer::Settings;
use flaneur_services::grpc::{Limits, Offer, Origin, ServeError, Server, in_process};
use flaneur_services::render::{RenderOptions, Rendering};
use flaneur_services::store::{Catalog, Store, StoreError};
use flaneur_streamer::{FetchLimits, Servers};

use super::Context;
use crate::descriptors;
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::output;
use crate::source;

const EXAMPLES: &str = "\
Examples:
  flaneur serve scenes                       all of a folder, and the web page
  flaneur serve scenes/paris                 one scene alone
  flaneur serve scenes s3://bucket/streets   scenes of several stores
  flaneur serve scenes --listen 0.0.0.0:80   to all who reach this machine
  flaneur serve scenes --no-render           data alone: no pictures, no page
  flaneur serve http://10.0.0.5:7878         pictures of what another server has

Prints one line, `serving http://ADDRESS`, once calls are answered. Scenes that are published \
while it runs are found. Ctrl-C or SIGTERM ends it once the calls in flight are done; a second \
one ends it at once.

Cloud stores take their settings from the environment, as in AWS_REGION, AWS_ENDPOINT, \
AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY.";

/// Arguments of `flaneur serve`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ServeArguments {
    /// Folder or URL (s3://, gs://, az://) with scenes, or of one scene; or http://host:port of a server
    /// whose scenes are rendered here, several with commas between them
    #[arg(value_name = "STORE", required = true)]
    stores: Vec<String>,
    /// Address to listen on; port 0 is any free one
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:7878")]
    listen: SocketAddr,
    /// Whose pages may call, besides the server's own: scheme, host and port; * for all. May be
    /// given again
    #[arg(long, value_name = "ORIGIN")]
    allow_origin: Vec<Origin>,
    /// Most calls in flight; more are refused
    #[arg(long, value_name = "N", default_value_t = Limits::default().calls)]
    max_calls: usize,
    /// Serve data alone: no pictures, no web page
    #[arg(long)]
    no_render: bool,
    /// Most people who walk, and pictures that are waited for, at a time; more are refused
    #[arg(long, value_name = "N", default_value_t = RenderOptions::default().sessions as u64,
        value_parser = clap::value_parser!(u64).range(1..=100_000))]
    max_sessions: u64,
    /// Most pixels of a picture
    #[arg(long, value_name = "N", default_value_t = RenderOptions::default().pixels,
        value_parser = clap::value_parser!(u64).range(1..=1 << 25))]
    max_pixels: u64,
    /// Most views a second of one session; more are told when to come
    #[arg(long, value_name = "N", default_value_t = RenderOptions::default().views_per_s,
        value_parser = clap::value_parser!(u32).range(1..=10_000))]
    max_views_per_s: u32,
    /// What a frame takes, about, while its view moves, milliseconds; coarser where it must be
    #[arg(long, value_name = "MS", default_value_t = 100,
        value_parser = clap::value_parser!(u64).range(1..=60_000))]
    budget_ms: u64,
    /// A session of which nothing is heard for so many seconds ends
    #[arg(long, value_name = "SECONDS", default_value_t = RenderOptions::default().idle.as_secs(),
        value_parser = clap::value_parser!(u64).range(1..=86_400))]
    max_idle: u64,
    #[command(flatten)]
    gpu_memory: GpuMemory,
}

/// Serves until Ctrl-C.
pub(crate) async fn run(arguments: ServeArguments, context: &Context) -> Result<(), Exit> {
    let (data, servers) = origin(&arguments).await?;
    let rendering = match servers {
        Some(servers) => Some(rendering(servers, &arguments).await?),
        None => None,
    };
    let connections = descriptors::connections(Limits::default().connections);
    let limits = Limits { calls: arguments.max_calls, connections, ..Limits::default() };
    let offer = Offer { data, rendering, origins: arguments.allow_origin };
    let server = Server::bind(offer, arguments.listen, limits).await.map_err(of_server)?;
    output::print(&format!("serving http://{}\n", server.address()))?;
    tracing::info!(address = %server.address(), "serving");
    server.serve(context.cancel.cancelled()).await.map_err(of_server)
}

/// The scenes whose data are served, and where those come from that are rendered.
async fn origin(arguments: &ServeArguments) -> Result<(Option<Catalog>, Option<Servers>), Exit> {
    let stores = &arguments.stores;
    if stores.iter().any(|store| source::is_server(store)) {
        let [servers] = &stores[..] else {
            let problem = "a server is rendered for alone; several with the same scenes have commas \
                           between them";
            return Err(Exit::bad_input(anyhow::anyhow!("{problem}: {stores:?}")));
        };
        if arguments.no_render {
            let problem = "a server's data are its own to serve: leave --no-render out";
            return Err(Exit::bad_input(anyhow::anyhow!("{problem}: {servers:?}")));
        }
        return Ok((None, Some(source::servers(servers).await?)));
    }
    let opened: Result<Vec<Store>, StoreError> =
        stores.iter().map(|url| Store::open_existing(url)).collect();
    let catalog = Catalog::open(opened.map_err(of_store)?).await.map_err(of_store)?;
    let scenes = catalog.names().await.map_err(of_store)?;
    if scenes.is_empty() {
        tracing::warn!(?stores, "no scene is published there yet");
    }
    tracing::info!(?scenes, "opened");
    let servers = if arguments.no_render {
        None
    } else {
        Some(in_process(catalog.clone()).await.map_err(of_server)?.into())
    };
    Ok((Some(catalog), servers))
}

/// The render service; without a driver it says so to whoever calls.
async fn rendering(servers: Servers, arguments: &ServeArguments) -> Result<Rendering, Exit> {
    let gpu_memory_bytes = arguments.gpu_memory.bytes();
    let options = RenderOptions {
        settings: Settings { gpu_memory_bytes, ..Settings::default() },
        limits: arguments.gpu_memory.fitted(FetchLimits::default()),
        budget: Duration::from_millis(arguments.budget_ms),
        pixels: arguments.max_pixels,
        sessions: usize::try_from(arguments.max_sessions).unwrap_or(usize::MAX),
        idle: Duration::from_secs(arguments.max_idle),
        views_per_s: arguments.max_views_per_s,
        ..RenderOptions::default()
    };
    let rendering = tokio::task::spawn_blocking(move || Rendering::new(servers, options));
    let rendering = rendering.await.map_err(Exit::failed)?;
    match rendering.adapter() {
        Ok(adapter) => tracing::info!(adapter, "rendering"),
        Err(reason) => tracing::warn!(reason, "render calls will be refused"),
    }
    Ok(rendering)
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

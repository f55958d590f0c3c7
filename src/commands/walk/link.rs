//! The server at the far end of a throttled connection.

use std::net::{Ipv4Addr, SocketAddr};

use flaneur_services::grpc::{Limits, Server};
use tokio_util::sync::{CancellationToken, DropGuard};

use crate::exit::Exit;
use crate::source::{ServerAddress, Source, is_server, open_store};
use crate::throttle::{Conditions, Proxy};

/// A server, a throttled way to it, and a direct one. A server that was started for it ends with it.
pub(super) struct Link {
    proxy: Proxy,
    /// `host:port`.
    server: String,
    scene: String,
    _stop: Option<DropGuard>,
}

impl Link {
    /// Serves a store on a port of this machine, or takes the server that `source` names; finds the
    /// scene's name out where there is only one.
    pub(super) async fn open(source: &str, conditions: Conditions) -> Result<Self, Exit> {
        let (server, stop) = if is_server(source) {
            (ServerAddress::parse(source)?.authority, None)
        } else {
            let catalog = open_store(source).await?;
            let any_port = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
            let server = Server::bind(catalog, any_port, Limits::default()).await?;
            let (address, stop) = (server.address(), CancellationToken::new());
            let stopped = stop.clone();
            tokio::spawn(async move {
                // Nobody waits for calls in flight at its end.
                let serving = server.serve(std::future::pending());
                if let Some(Err(error)) = stopped.run_until_cancelled(serving).await {
                    tracing::error!(%error, "the server of the store failed");
                }
            });
            (address.to_string(), Some(stop.drop_guard()))
        };
        let scene = Source::open(source).await?.scene_name().await?;
        let proxy = Proxy::start(server.clone(), conditions).await?;
        Ok(Self { proxy, server, scene, _stop: stop })
    }

    /// Connects as a visitor would.
    pub(super) async fn throttled(&self) -> Result<Source, Exit> {
        Source::of_scene(&self.proxy.address().to_string(), &self.scene).await
    }

    /// Connects past the proxy.
    pub(super) async fn direct(&self) -> Result<Source, Exit> {
        Source::of_scene(&self.server, &self.scene).await
    }

    /// The scene's name.
    pub(super) fn scene(&self) -> &str {
        &self.scene
    }

    /// Bytes that TCP has carried through the proxy, to the visitor and back.
    pub(super) fn carried(&self) -> [u64; 2] {
        [self.proxy.bytes_to_client(), self.proxy.bytes_to_server()]
    }
}

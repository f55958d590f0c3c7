//! The services on a port.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::net::{TcpListener, TcpSocket};
use tower_http::cors::CorsLayer;

use super::connections::connections;
use super::origins;
use super::routes::{Answers, Limits, Offer};

/// How long calls in flight may go on once the server is asked to stop.
const DRAIN: Duration = Duration::from_secs(10);

/// How often a quiet connection is asked whether it lives, and how long it may take to say so: it hears
/// of it behind all that was sent before.
const KEEPALIVE: (Duration, Duration) = (Duration::from_secs(30), Duration::from_secs(60));

/// Connections that may wait to be accepted; systems may grant fewer.
const BACKLOG: u32 = 4096;

/// Bytes of requests that may be under way unacknowledged, by stream and by connection: requests
/// are small, and whoever sends more waits. How much of an answer is, its client says.
const REQUEST_WINDOW: (u32, u32) = (256 << 10, 1 << 20);

/// Why the services cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}; choose another with --listen")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
    /// The services could not be put together.
    #[error("cannot set up the services: {0}")]
    SetUp(String),
    /// The server failed while it ran.
    #[error("the server failed: {0}")]
    Transport(#[from] tonic::transport::Error),
}

/// The services, listening.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    answers: Answers,
    limits: Limits,
    cors: CorsLayer,
}

impl Server {
    /// Listens on `address`; port 0 is any free one. Calls wait until [`Server::serve`].
    pub async fn bind(
        offer: impl Into<Offer>,
        address: SocketAddr,
        limits: Limits,
    ) -> Result<Self, ServeError> {
        let failed = |source| ServeError::Bind { address, source };
        let listener = listen(address).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let offer = offer.into();
        let cors = origins::layer(&offer.origins);
        let answers = Answers::new(offer, &limits).await?;
        Ok(Self { listener, address, answers, limits, cors })
    }

    /// The address that is listened on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Serves until `stop` completes; then no new calls are taken, and those in flight have
    /// ten seconds to end.
    pub async fn serve(self, stop: impl Future<Output = ()>) -> Result<(), ServeError> {
        let Self { listener, answers, limits, cors, .. } = self;
        let incoming = connections(listener, limits.connections);
        let (stopping, stopped) = tokio::sync::watch::channel(false);
        let mut builder = tonic::transport::Server::builder()
            .accept_http1(true)
            .max_concurrent_streams(limits.calls_per_connection)
            .http2_keepalive_interval(Some(KEEPALIVE.0))
            .http2_keepalive_timeout(Some(KEEPALIVE.1))
            .initial_stream_window_size(REQUEST_WINDOW.0)
            .initial_connection_window_size(REQUEST_WINDOW.1)
            .layer(cors);
        let wait = |mut stopped: tokio::sync::watch::Receiver<bool>| async move {
            // The sender lives as long as this function; an error is a stop as well.
            let _ = stopped.wait_for(|stopped| *stopped).await;
        };
        let routes = answers.routes.clone();
        let serving = builder
            .add_routes(routes)
            .serve_with_incoming_shutdown(incoming, wait(stopped.clone()));
        let orders = async {
            stop.await;
            tracing::info!("stopping: no new calls");
            answers.stop().await;
            let _ = stopping.send(true);
            tokio::time::sleep(DRAIN).await;
            tracing::warn!("calls still in flight are cut off");
        };
        let tidying = async {
            loop {
                tokio::time::sleep(Duration::from_secs(5)).await;
                answers.metrics.tidy();
            }
        };
        tokio::select! {
            outcome = serving => Ok(outcome?),
            () = orders => Ok(()),
            () = tidying => Ok(()),
        }
    }
}

/// Listens, with room for as many connections as come at once when all clients come back.
fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    // As `TcpListener::bind` has it: a restarted server takes its port again, at once.
    #[cfg(not(windows))]
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

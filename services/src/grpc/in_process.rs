//! The services without a network: for a program that reads a store as a client would.

use hyper_util::rt::TokioIo;
use tokio::io::DuplexStream;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::transport::{Channel, Endpoint};

use super::routes::{Answers, Limits};
use super::server::ServeError;
use crate::store::Catalog;

/// Bytes that may be under way unacknowledged, by stream and by connection.
const WINDOW: (u32, u32) = (4 << 20, 16 << 20);

/// Bytes that a pipe holds before its writer waits.
const PIPE_BYTES: usize = 1 << 20;

/// A channel to the services over `catalog`, in this process. The services end when the channel
/// and its clones are dropped.
pub async fn in_process(catalog: Catalog) -> Result<Channel, ServeError> {
    let limits = Limits::default();
    let answers = Answers::new(catalog.into(), &limits).await?;
    let (pipes, incoming) = mpsc::channel::<Result<DuplexStream, std::io::Error>>(1);
    let server = tonic::transport::Server::builder()
        .add_routes(answers.routes)
        .serve_with_incoming(ReceiverStream::new(incoming));
    tokio::spawn(async move {
        if let Err(error) = server.await {
            tracing::error!(%error, "services in this process failed");
        }
    });
    // Asked for again whenever a connection is lost.
    let connector = tower::service_fn(move |_: http::Uri| {
        let pipes = pipes.clone();
        async move {
            let (ours, theirs) = tokio::io::duplex(PIPE_BYTES);
            pipes
                .send(Ok(theirs))
                .await
                .map_err(|_| std::io::Error::from(std::io::ErrorKind::ConnectionRefused))?;
            Ok::<_, std::io::Error>(TokioIo::new(ours))
        }
    });
    Ok(Endpoint::from_static("http://in-process")
        .initial_stream_window_size(WINDOW.0)
        .initial_connection_window_size(WINDOW.1)
        .connect_with_connector_lazy(connector))
}

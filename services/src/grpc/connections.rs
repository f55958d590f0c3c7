//! Connections as they come in: so many at a time, and none that says nothing.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use futures::stream::{self, Stream};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::Sleep;
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};
use tonic::transport::server::Connected;

use super::unsent;

/// How long a connection may say nothing at all. After its first bytes HTTP has its own rules.
const SILENCE: Duration = Duration::from_secs(20);

/// How long to wait where the system has no more connections to give: no files, say.
const EXHAUSTED: Duration = Duration::from_millis(100);

/// A connection.
pub(super) struct Connection {
    socket: TcpStream,
    closer: Closer,
    closed: Pin<Box<WaitForCancellationFutureOwned>>,
    /// Ends when the first bytes should have come; gone once they have.
    silence: Option<Pin<Box<Sleep>>>,
    _slot: OwnedSemaphorePermit,
}

/// Closes a connection, with all calls on it. Every request carries that of its connection.
#[derive(Clone)]
pub(super) struct Closer(CancellationToken);

impl Closer {
    pub(super) fn close(&self) {
        self.0.cancel();
    }
}

/// The connections that `listener` takes, `limit` at a time. Further ones are closed at once,
/// so that a client can go elsewhere. Errors do not end it.
pub(super) fn connections(
    listener: TcpListener,
    limit: usize,
) -> impl Stream<Item = io::Result<Connection>> {
    let slots = Arc::new(Semaphore::new(limit));
    stream::unfold((listener, slots), async |(listener, slots)| {
        loop {
            match listener.accept().await {
                Ok((socket, peer)) => match Arc::clone(&slots).try_acquire_owned() {
                    Ok(slot) => {
                        let connection = Connection::new(socket, slot);
                        return Some((Ok(connection), (listener, slots)));
                    }
                    Err(_) => tracing::warn!(%peer, "too many connections: one is closed"),
                },
                Err(error) => {
                    tracing::warn!(%error, "cannot accept a connection");
                    tokio::time::sleep(EXHAUSTED).await;
                }
            }
        }
    })
}

impl Connection {
    fn new(socket: TcpStream, slot: OwnedSemaphorePermit) -> Self {
        if let Err(error) = socket.set_nodelay(true) {
            tracing::debug!(%error, "small messages may wait");
        }
        unsent::limit(&socket);
        let token = CancellationToken::new();
        Self {
            socket,
            closed: Box::pin(token.clone().cancelled_owned()),
            closer: Closer(token),
            silence: Some(Box::pin(tokio::time::sleep(SILENCE))),
            _slot: slot,
        }
    }
}

impl Connected for Connection {
    type ConnectInfo = Closer;

    fn connect_info(&self) -> Closer {
        self.closer.clone()
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if self.closed.as_mut().poll(context).is_ready() {
            return Poll::Ready(Err(io::ErrorKind::ConnectionAborted.into()));
        }
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.socket).poll_read(context, buffer);
        if buffer.filled().len() > before {
            self.silence = None;
        }
        if let Some(silence) = &mut self.silence
            && read.is_pending()
            && silence.as_mut().poll(context).is_ready()
        {
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        }
        read
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.socket).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.socket).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.socket).poll_shutdown(context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.socket).poll_write_vectored(context, slices)
    }

    fn is_write_vectored(&self) -> bool {
        self.socket.is_write_vectored()
    }
}

//! A connection that breaks where a test wants it to: a proxy that counts what it has delivered
//! to the client, over all connections, and does something at given counts.

use std::collections::VecDeque;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::{AbortHandle, JoinSet};

/// What happens to a connection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    /// It is reset at both ends.
    Cut,
    /// Nothing more is delivered, on any connection, until [`Link::cut`].
    Hold,
}

/// The proxy. It ends with its connections when it is dropped.
pub(crate) struct Link {
    /// Where it listens.
    pub(crate) url: String,
    shared: Arc<Shared>,
    task: AbortHandle,
}

struct Shared {
    state: Mutex<State>,
    /// Faults that have happened.
    happened: watch::Sender<usize>,
    holds: watch::Sender<bool>,
    /// How often all connections were cut.
    cuts: watch::Sender<usize>,
    /// Connections that clients have asked for.
    asked: watch::Sender<usize>,
}

struct State {
    /// Where new connections go.
    server: SocketAddr,
    delivered: u64,
    /// Each with the count at which it happens, in order.
    faults: VecDeque<(u64, Fault)>,
}

impl Link {
    /// Listens for connections to the server at `url`; `faults` happen once so many bytes have been
    /// delivered to the client, in that order.
    pub(crate) async fn start(url: &str, faults: impl IntoIterator<Item = (u64, Fault)>) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.expect("a port");
        let shared = Arc::new(Shared {
            state: Mutex::new(State {
                server: address(url),
                delivered: 0,
                faults: faults.into_iter().collect(),
            }),
            happened: watch::Sender::new(0),
            holds: watch::Sender::new(false),
            cuts: watch::Sender::new(0),
            asked: watch::Sender::new(0),
        });
        let url = format!("http://{}", listener.local_addr().expect("bound"));
        let task = tokio::spawn(accept(listener, Arc::clone(&shared))).abort_handle();
        Self { url, shared, task }
    }

    /// Bytes that the client has received.
    pub(crate) fn delivered(&self) -> u64 {
        self.shared.state().delivered
    }

    /// Returns once `count` faults have happened.
    pub(crate) async fn happened(&self, count: usize) {
        let mut happened = self.shared.happened.subscribe();
        happened.wait_for(|&faults| faults >= count).await.expect("it lives as long as this");
    }

    /// Returns once clients have asked for `count` more connections.
    pub(crate) async fn asked(&self, count: usize) {
        let mut asked = self.shared.asked.subscribe();
        let before = *asked.borrow_and_update();
        asked.wait_for(|&asked| asked >= before + count).await.expect("it lives as long as this");
    }

    /// Resets all connections, with what was under way on them. New ones are delivered again.
    pub(crate) fn cut(&self) {
        // In this order: nothing of what was held slips through.
        self.shared.cuts.send_modify(|cuts| *cuts += 1);
        self.shared.holds.send_replace(false);
    }

    /// New connections go to another server.
    pub(crate) fn lead_to(&self, url: &str) {
        self.shared.state().server = address(url);
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How much of `bytes` is delivered before the next fault; where that is nothing, the fault.
    fn take(&self, bytes: usize) -> Result<usize, Fault> {
        let mut state = self.state();
        let before = match state.faults.front() {
            Some(&(at, _)) => bytes.min(at.saturating_sub(state.delivered) as usize),
            None => bytes,
        };
        if before > 0 {
            state.delivered += before as u64;
            return Ok(before);
        }
        let (_, fault) = state.faults.pop_front().expect("it is why nothing passes");
        if fault == Fault::Hold {
            self.holds.send_replace(true);
        }
        self.happened.send_modify(|count| *count += 1);
        Err(fault)
    }

    /// Carries one connection until either end closes it, or a fault does.
    async fn carry(&self, mut client: TcpStream) -> io::Result<()> {
        let server = self.state().server;
        let mut server = TcpStream::connect(server).await?;
        let (mut from_client, mut to_client) = client.split();
        let (mut from_server, mut to_server) = server.split();
        let mut cuts = self.cuts.subscribe();
        let cut = tokio::select! {
            biased;
            _ = cuts.changed() => true,
            _ = tokio::io::copy(&mut from_client, &mut to_server) => false,
            cut = self.deliver(&mut from_server, &mut to_client) => cut.unwrap_or(false),
        };
        if cut {
            client.set_zero_linger()?;
            server.set_zero_linger()?;
        }
        Ok(())
    }

    /// Whether the connection is to be cut.
    async fn deliver(
        &self,
        server: &mut (impl AsyncReadExt + Unpin),
        client: &mut (impl AsyncWriteExt + Unpin),
    ) -> io::Result<bool> {
        let mut buffer = vec![0; 1 << 14];
        let mut holds = self.holds.subscribe();
        loop {
            let read = server.read(&mut buffer).await?;
            if read == 0 {
                return Ok(false);
            }
            let mut rest = &buffer[..read];
            while !rest.is_empty() {
                holds.wait_for(|holds| !holds).await.map_err(io::Error::other)?;
                match self.take(rest.len()) {
                    Ok(bytes) => {
                        client.write_all(&rest[..bytes]).await?;
                        rest = &rest[bytes..];
                    }
                    Err(Fault::Cut) => return Ok(true),
                    Err(Fault::Hold) => {}
                }
            }
        }
    }
}

async fn accept(listener: TcpListener, shared: Arc<Shared>) {
    let mut connections = JoinSet::new();
    while let Ok((client, _)) = listener.accept().await {
        shared.asked.send_modify(|count| *count += 1);
        let shared = Arc::clone(&shared);
        // What goes wrong closes the connection, which is all that its client can be told.
        connections.spawn(async move { shared.carry(client).await });
    }
}

fn address(url: &str) -> SocketAddr {
    url.trim_start_matches("http://").parse().expect("an address")
}

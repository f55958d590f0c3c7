//! The proxy.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio::time::sleep;
use tokio_util::sync::{CancellationToken, DropGuard};

use super::Bandwidth;
use super::lane::Lane;

/// What a link is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conditions {
    /// Each way.
    pub(crate) bandwidth: Bandwidth,
    /// Each way.
    pub(crate) latency: Duration,
}

/// Carries connections to a server as a link would. It ends, and cuts its connections, when it is
/// dropped.
#[derive(Debug)]
pub(crate) struct Proxy {
    address: SocketAddr,
    link: Arc<Link>,
    _stop: DropGuard,
}

#[derive(Debug)]
struct Link {
    /// `host:port` at its far end.
    server: String,
    latency: Duration,
    to_server: Lane,
    to_client: Lane,
}

impl Proxy {
    /// Listens on a free port of this machine, for connections to `server`, `host:port`.
    ///
    /// # Errors
    /// Where no port can be had.
    pub(crate) async fn start(server: String, conditions: Conditions) -> io::Result<Self> {
        let Conditions { bandwidth, latency } = conditions;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
        let address = listener.local_addr()?;
        let [to_server, to_client] = [(); 2].map(|()| Lane::new(bandwidth, latency));
        let link = Arc::new(Link { server, latency, to_server, to_client });
        let stop = CancellationToken::new();
        let (stopped, shared) = (stop.clone(), Arc::clone(&link));
        tokio::spawn(async move {
            // Its connections end with the future.
            stopped.run_until_cancelled(accept(listener, shared)).await;
        });
        Ok(Self { address, link, _stop: stop.drop_guard() })
    }

    /// Where it listens.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Bytes that clients have received, of all that TCP carries.
    pub(crate) fn bytes_to_client(&self) -> u64 {
        self.link.to_client.delivered()
    }

    /// Bytes that the server has received.
    pub(crate) fn bytes_to_server(&self) -> u64 {
        self.link.to_server.delivered()
    }
}

async fn accept(listener: TcpListener, link: Arc<Link>) {
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((client, _)) => {
                    let link = Arc::clone(&link);
                    connections.spawn(async move {
                        if let Err(error) = link.connect(client).await {
                            tracing::debug!(%error, server = link.server, "a connection was cut");
                        }
                    });
                }
                // Out of file handles, say: some may be free again soon.
                Err(error) => {
                    tracing::warn!(%error, "cannot accept a connection to the throttled server");
                    sleep(Duration::from_millis(100)).await;
                }
            },
            Some(_) = connections.join_next() => {}
        }
    }
}

impl Link {
    /// Carries one connection to its end. Each way ends on its own; an error ends both.
    async fn connect(&self, client: TcpStream) -> io::Result<()> {
        // The client's system has answered at once; what the client has sent since stays with it
        // until the answer could have come.
        sleep(2 * self.latency).await;
        let server = TcpStream::connect(&self.server).await?;
        for stream in [&client, &server] {
            stream.set_nodelay(true)?;
        }
        let (from_client, to_client) = client.into_split();
        let (from_server, to_server) = server.into_split();
        let down = async {
            sleep(self.latency).await;
            self.to_client.carry(from_server, to_client).await
        };
        tokio::try_join!(self.to_server.carry(from_client, to_server), down).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    use super::*;

    async fn proxy(latency_ms: u64) -> (TcpListener, Proxy) {
        let server = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.expect("a port");
        let conditions = Conditions {
            bandwidth: "unlimited".parse().expect("a rate"),
            latency: Duration::from_millis(latency_ms),
        };
        let address = server.local_addr().expect("bound").to_string();
        let proxy = Proxy::start(address, conditions).await.expect("a port");
        (server, proxy)
    }

    async fn pair(server: &TcpListener, proxy: &Proxy) -> (TcpStream, TcpStream) {
        let client = TcpStream::connect(proxy.address()).await.expect("listening");
        let (served, _) = server.accept().await.expect("a connection");
        (client, served)
    }

    /// The client says all it has to say and closes its half; the server, which waits for that,
    /// answers all the same.
    #[tokio::test]
    async fn bytes_pass_both_ways_and_halves_close_alone() {
        let (server, proxy) = proxy(3).await;
        let (mut client, mut served) = pair(&server, &proxy).await;
        let said: Vec<u8> = (0..3_000_000_u32).map(|i| (i ^ (i >> 7)) as u8).collect();
        let serve = async {
            let mut heard = Vec::new();
            served.read_to_end(&mut heard).await.expect("open");
            served.write_all(&heard).await.expect("still open");
            served.shutdown().await.expect("still open");
        };
        let ask = async {
            let (mut from, mut to) = client.split();
            to.write_all(&said).await.expect("open");
            to.shutdown().await.expect("open");
            let mut answer = Vec::new();
            from.read_to_end(&mut answer).await.expect("open");
            answer
        };
        let ((), answer) = tokio::join!(serve, ask);
        assert!(answer == said);
        assert_eq!(proxy.bytes_to_server(), said.len() as u64);
        assert_eq!(proxy.bytes_to_client(), said.len() as u64);
    }

    #[tokio::test]
    async fn a_connection_that_is_cut_is_cut_at_its_other_end() {
        let (server, proxy) = proxy(1).await;
        for client_cuts in [true, false] {
            let (client, served) = pair(&server, &proxy).await;
            let (cut, mut left) = if client_cuts { (client, served) } else { (served, client) };
            // Data that is there and unread makes it a reset, not an end.
            left.write_all(&[1; 1000]).await.expect("open");
            cut.readable().await.expect("open");
            drop(cut);
            while left.write_all(&[0; 1 << 16]).await.is_ok() {}
        }
    }

    #[tokio::test]
    async fn all_ends_with_the_proxy() {
        let (server, proxy) = proxy(1).await;
        let address = proxy.address();
        let (mut client, mut served) = pair(&server, &proxy).await;
        drop(proxy);
        let mut byte = [0];
        for end in [&mut client, &mut served] {
            assert!(matches!(end.read(&mut byte).await, Ok(0) | Err(_)));
        }
        // The listener may go a moment later.
        while TcpStream::connect(address).await.is_ok() {
            tokio::task::yield_now().await;
        }
    }

    #[tokio::test]
    async fn a_server_that_is_not_there_ends_a_connection() {
        let (server, proxy) = proxy(1).await;
        drop(server);
        let mut client = TcpStream::connect(proxy.address()).await.expect("listening");
        let mut byte = [0];
        assert!(matches!(client.read(&mut byte).await, Ok(0) | Err(_)));
    }
}

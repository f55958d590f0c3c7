//! What waits in the system of a connection.

use tokio::net::TcpStream;

/// Bytes that a connection takes beyond what is under way. Systems take megabytes, which a slow link
/// carries for seconds: by then the client may have cancelled them, or asked for something more
/// urgent. What is under way keeps a fast link busy until more is written.
const UNSENT_BYTES: u32 = 128 << 10;

/// Has the system take little of a connection that it cannot send yet, where it knows how.
pub(super) fn limit(connection: &TcpStream) {
    #[cfg(any(target_os = "linux", target_os = "android"))]
    if let Err(error) = socket2::SockRef::from(connection).set_tcp_notsent_lowat(UNSENT_BYTES) {
        tracing::debug!(%error, "what waits in the system is not limited");
    }
    let _ = (connection, UNSENT_BYTES);
}

#[cfg(all(test, any(target_os = "linux", target_os = "android")))]
mod tests {
    use std::io::ErrorKind;
    use std::net::Ipv4Addr;

    use tokio::net::{TcpListener, TcpSocket};

    use super::*;

    /// How much a connection takes whose receiver does not read.
    async fn taken(limited: bool) -> usize {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.expect("a port");
        let receiver = TcpSocket::new_v4().expect("a socket");
        receiver.set_recv_buffer_size(1 << 16).expect("an allowed size");
        let address = listener.local_addr().expect("bound");
        let (received, accepted) = tokio::join!(receiver.connect(address), listener.accept());
        let (_received, (connection, _)) = (received.expect("open"), accepted.expect("open"));
        if limited {
            limit(&connection);
        }
        let mut taken = 0;
        loop {
            match connection.try_write(&[0; 1 << 14]) {
                Ok(bytes) => taken += bytes,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    // What is under way may still make room.
                    let wait = std::time::Duration::from_millis(50);
                    if tokio::time::timeout(wait, connection.writable()).await.is_err() {
                        return taken;
                    }
                }
                Err(error) => panic!("{error}"),
            }
        }
    }

    #[tokio::test]
    async fn a_connection_takes_little_that_it_cannot_send() {
        let (limited, unlimited) = (taken(true).await, taken(false).await);
        assert!(limited < 1 << 19 && limited < unlimited / 2, "{limited} of {unlimited}");
    }
}

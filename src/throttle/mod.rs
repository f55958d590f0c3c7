//! A network that is slower than this machine: a TCP proxy that carries bytes as a link of a given
//! bandwidth and latency would.
//!
//! What is modelled, for any number of connections over one link:
//!
//! - **bandwidth**, each way on its own: bytes leave one after another at that rate, and up to 20 ms
//!   of them wait for it. Connections share it in the order in which their bytes come;
//! - **latency**: every byte, and the end of a stream, arrives so much later, each way;
//! - **setting a connection up**: a client may send once its SYN was answered, which takes the latency
//!   twice, and the server once that was acknowledged, after three times the latency.
//!
//! What is not: loss and jitter, the slow start of a congestion window, name resolution, TLS. Time on the
//! way between proxy and server comes on top. What the server has handed to its own system before
//! the proxy takes it waits there, as it would before a real link: a stream that is cancelled still
//! brings that.

mod bandwidth;
mod lane;
mod latency;
mod proxy;

pub(crate) use bandwidth::Bandwidth;
pub(crate) use latency::parse_latency;
pub(crate) use proxy::{Conditions, Proxy};

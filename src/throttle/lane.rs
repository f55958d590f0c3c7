//! One direction of a link.

use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until};

use super::Bandwidth;

/// What may wait for the link, as the time that it then takes: enough that the link never idles while
/// there is something to carry, little enough that what is urgent need not wait long.
const QUEUE: Duration = Duration::from_millis(20);
/// Bytes that travel together: a packet at low rates, more where packets pass faster than timers run.
const CHUNK: [usize; 2] = [1448, 16 << 10];
/// Chunks that may be under way: 64 MiB at most, a gigabit over half a second.
const UNDER_WAY: usize = 4096;

/// A direction, shared by the connections that use it.
#[derive(Debug)]
pub(super) struct Lane {
    bandwidth: Bandwidth,
    latency: Duration,
    /// When all that was accepted will have left.
    free_at: Mutex<Instant>,
    delivered: AtomicU64,
}

impl Lane {
    pub(super) fn new(bandwidth: Bandwidth, latency: Duration) -> Self {
        let free_at = Mutex::new(Instant::now());
        Self { bandwidth, latency, free_at, delivered: AtomicU64::new(0) }
    }

    /// Bytes that arrived at the far end, of all connections.
    pub(super) fn delivered(&self) -> u64 {
        self.delivered.load(Ordering::Relaxed)
    }

    /// Carries everything from `from` to `to`, and then its end. Memory is bounded: what the link does
    /// not take stays with the sender.
    ///
    /// # Errors
    /// Where either side fails; what is under way is lost.
    pub(super) async fn carry(
        &self,
        mut from: impl AsyncRead + Unpin,
        mut to: impl AsyncWrite + Unpin,
    ) -> io::Result<()> {
        let (accepted, mut under_way) = mpsc::channel::<(Instant, Vec<u8>)>(UNDER_WAY);
        let accept = async move {
            loop {
                let mut chunk = Vec::with_capacity(self.chunk());
                let bytes = (&mut from).take(self.chunk() as u64).read_buf(&mut chunk).await?;
                let leaves = self.leaves(bytes);
                // Where nobody receives any more the other half has failed, and says so.
                let received = accepted.send((leaves + self.latency, chunk)).await.is_ok();
                if bytes == 0 || !received {
                    return Ok(());
                }
                sleep_until(leaves.checked_sub(QUEUE).unwrap_or(leaves)).await;
            }
        };
        let deliver = async {
            while let Some((arrives, chunk)) = under_way.recv().await {
                sleep_until(arrives).await;
                if chunk.is_empty() {
                    break;
                }
                to.write_all(&chunk).await?;
                self.delivered.fetch_add(chunk.len() as u64, Ordering::Relaxed);
            }
            to.shutdown().await
        };
        tokio::try_join!(accept, deliver).map(|_| ())
    }

    /// When the last of so many bytes, accepted now, will have left.
    fn leaves(&self, bytes: usize) -> Instant {
        let mut free_at = self.free_at.lock().unwrap_or_else(PoisonError::into_inner);
        *free_at = (*free_at).max(Instant::now()) + self.bandwidth.time_for(bytes);
        *free_at
    }

    /// Most bytes of a chunk: those that pass in a millisecond, the grain of timers.
    fn chunk(&self) -> usize {
        let [least, most] = CHUNK;
        let bits = self.bandwidth.bits_per_second().unwrap_or(f64::INFINITY);
        ((bits / 8e3) as usize).clamp(least, most)
    }
}

#[cfg(test)]
mod tests {
    use tokio::io::{DuplexStream, duplex};

    use super::*;

    fn lane(bandwidth: &str, latency_ms: u64) -> Lane {
        let bandwidth = bandwidth.parse().expect("a rate");
        Lane::new(bandwidth, Duration::from_millis(latency_ms))
    }

    fn noise(bytes: usize) -> Vec<u8> {
        let mut state = 1_u32;
        let next = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        (0..bytes).map(next).collect()
    }

    async fn send(mut to: DuplexStream, bytes: &[u8]) {
        to.write_all(bytes).await.expect("open");
    }

    /// What comes out, and when its first and its last byte do, seconds.
    async fn received(mut from: DuplexStream) -> (Vec<u8>, f64, f64) {
        let (started, mut bytes) = (Instant::now(), Vec::new());
        let mut times = [f64::NAN; 2];
        while from.read_buf(&mut bytes).await.expect("open") > 0 {
            times[1] = started.elapsed().as_secs_f64();
            times[0] = if times[0].is_nan() { times[1] } else { times[0] };
        }
        (bytes, times[0], times[1])
    }

    #[tokio::test(start_paused = true)]
    async fn bytes_arrive_unchanged_at_the_rate_and_after_the_latency() {
        for (bandwidth, bits) in [("2M", 2e6), ("10M", 10e6), ("300M", 300e6), ("1G", 1e9)] {
            let lane = lane(bandwidth, 50);
            let sent = noise((bits / 8.0) as usize);
            let ((a, from), (to, b)) = (duplex(1 << 16), duplex(1 << 24));
            let ((), carried, (bytes, first, last)) =
                tokio::join!(send(a, &sent), lane.carry(from, to), received(b));
            carried.expect("carried");
            assert!(bytes == sent, "{bandwidth}");
            assert_eq!(lane.delivered(), sent.len() as u64);
            // A second's worth; timers have a grain of a millisecond.
            assert!((first - 0.05).abs() < 0.01, "{bandwidth}: first after {first} s");
            assert!((last - 1.05).abs() < 0.02, "{bandwidth}: last after {last} s");
        }
    }

    #[tokio::test(start_paused = true)]
    async fn connections_share_a_link() {
        let lane = lane("8M", 0);
        let sent = noise(500_000);
        let transfer = || async {
            let ((a, from), (to, b)) = (duplex(1 << 16), duplex(1 << 16));
            tokio::join!(send(a, &sent), lane.carry(from, to), received(b)).2
        };
        let ((one, _, one_s), (two, _, two_s)) = tokio::join!(transfer(), transfer());
        assert!(one == sent && two == sent);
        for seconds in [one_s, two_s] {
            assert!((seconds - 1.0).abs() < 0.03, "half the rate each: {seconds} s");
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_sender_waits_for_the_link_not_for_memory() {
        let lane = lane("1M", 2000);
        let ((mut a, from), (to, _b)) = (duplex(1 << 10), duplex(1 << 10));
        let task = tokio::spawn(async move { lane.carry(from, to).await });
        let mut taken = 0;
        let pour = async {
            loop {
                a.write_all(&[0; 1000]).await.expect("open");
                taken += 1000;
            }
        };
        let second = Duration::from_secs(1);
        assert!(tokio::time::timeout(second, pour).await.is_err(), "it never ends by itself");
        // 125 kB have left, and 20 ms of them wait; nothing has arrived yet.
        assert!((125_000..=132_000).contains(&taken), "{taken}");
        task.abort();
    }

    #[tokio::test(start_paused = true)]
    async fn a_pause_is_no_credit_and_the_end_travels_too() {
        let lane = lane("8M", 100);
        let ((mut a, from), (to, b)) = (duplex(1 << 16), duplex(1 << 16));
        let sending = async {
            tokio::time::sleep(Duration::from_secs(5)).await;
            a.write_all(&[7; 100_000]).await.expect("open");
            tokio::time::sleep(Duration::from_secs(1)).await;
            drop(a);
        };
        let ended = async {
            let got = received(b).await;
            (got, Instant::now())
        };
        let started = Instant::now();
        let ((), carried, ((bytes, first, last), end)) =
            tokio::join!(sending, lane.carry(from, to), ended);
        carried.expect("carried");
        assert_eq!(bytes.len(), 100_000);
        // A tenth of a second for the bytes, whatever passed before.
        assert!((first - 5.1).abs() < 0.01 && (last - 5.2).abs() < 0.01, "{first} {last}");
        let end = (end - started).as_secs_f64();
        assert!((end - 6.1).abs() < 0.11 && end > last, "{end}");
    }

    #[tokio::test(start_paused = true)]
    async fn a_receiver_that_goes_ends_it() {
        let lane = lane("unlimited", 10);
        let ((mut a, from), (to, b)) = (duplex(1 << 10), duplex(1 << 10));
        drop(b);
        let carry = tokio::spawn(async move { lane.carry(from, to).await });
        while a.write_all(&[0; 512]).await.is_ok() {}
        assert!(carry.await.expect("no panic").is_err());
    }
}

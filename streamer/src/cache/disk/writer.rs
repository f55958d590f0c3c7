//! Writing behind: a thread, and a bounded queue before it.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;
use std::thread;
use std::time::Duration;

use bytes::Bytes;
use tokio::sync::{mpsc, oneshot};

use super::entry;
use super::folder::Folder;
use crate::cache::statistics::Counts;
use crate::cache::{CacheKey, Rank};

/// Orders that may wait.
const QUEUE: usize = 4096;
/// Bytes of payloads that may wait; what comes beyond is not written.
const QUEUE_BYTES: u64 = 64 << 20;
/// Orders that are dealt with in one turn. It ends in milliseconds, so that other processes
/// need not wait for long…
const TURN_ORDERS: usize = 32;
/// …and this is left to them between two of ours.
const PAUSE: Duration = Duration::from_millis(2);

#[derive(Debug)]
enum Order {
    Write { key: CacheKey, payload: Bytes, rank: Rank },
    Remove(CacheKey),
    Flush(oneshot::Sender<()>),
}

/// Hands orders to the thread that writes. That ends when this is dropped, after what waits.
#[derive(Debug)]
pub(super) struct Writer {
    orders: mpsc::Sender<Order>,
    waiting_bytes: Arc<AtomicU64>,
    counts: Arc<Counts>,
}

impl Writer {
    /// Starts the thread, which first brings the folder within its limit.
    pub(super) fn start(folder: Folder, counts: Arc<Counts>) -> io::Result<Self> {
        let (orders, receiver) = mpsc::channel(QUEUE);
        let waiting_bytes = Arc::<AtomicU64>::default();
        let worker = Worker {
            folder,
            orders: receiver,
            waiting_bytes: Arc::clone(&waiting_bytes),
            counts: Arc::clone(&counts),
            failed: false,
        };
        thread::Builder::new().name("cache".into()).spawn(move || worker.run())?;
        Ok(Self { orders, waiting_bytes, counts })
    }

    /// Has an entry written, unless too much waits for that.
    pub(super) fn write(&self, key: CacheKey, payload: Bytes, rank: Rank) {
        let bytes = payload.len() as u64;
        let room = self.waiting_bytes.fetch_add(bytes, Relaxed) + bytes <= QUEUE_BYTES;
        if !room || self.orders.try_send(Order::Write { key, payload, rank }).is_err() {
            self.waiting_bytes.fetch_sub(bytes, Relaxed);
            self.counts.not_written.fetch_add(1, Relaxed);
        }
    }

    /// Has an entry removed. Where the queue is full it stays: it will be found, refused and
    /// removed another time.
    pub(super) fn remove(&self, key: CacheKey) {
        drop(self.orders.try_send(Order::Remove(key)));
    }

    /// Returns once all orders before are dealt with.
    pub(super) async fn flush(&self) {
        let (done, wait) = oneshot::channel();
        if self.orders.send(Order::Flush(done)).await.is_ok() {
            // An error says that the thread has ended: nothing is left to wait for.
            drop(wait.await);
        }
    }
}

struct Worker {
    folder: Folder,
    orders: mpsc::Receiver<Order>,
    waiting_bytes: Arc<AtomicU64>,
    counts: Arc<Counts>,
    /// Writing has failed, and is not tried again.
    failed: bool,
}

impl Worker {
    fn run(mut self) {
        self.turn(&[]);
        let mut orders = Vec::new();
        while self.orders.blocking_recv_many(&mut orders, TURN_ORDERS) > 0 {
            self.turn(&orders);
            for order in orders.drain(..) {
                match order {
                    Order::Write { payload, .. } => {
                        self.waiting_bytes.fetch_sub(payload.len() as u64, Relaxed);
                    }
                    // Whoever waited may have gone.
                    Order::Flush(done) => _ = done.send(()),
                    Order::Remove(_) => {}
                }
            }
            thread::sleep(PAUSE);
        }
    }

    /// Deals with `orders` in one turn, or with none of the rest once one has failed.
    fn turn(&mut self, orders: &[Order]) {
        let mut done = 0;
        let outcome = if self.failed {
            Ok(())
        } else {
            self.folder.turn(|folder| {
                for order in orders {
                    match order {
                        Order::Write { key, payload, rank } => folder.store(key, payload, *rank)?,
                        Order::Remove(key) => folder.remove(&entry::file_name(key))?,
                        Order::Flush(_) => {}
                    }
                    done += 1;
                }
                Ok(())
            })
        };
        let left = orders.iter().skip(done).filter(|order| matches!(order, Order::Write { .. }));
        self.counts.not_written.fetch_add(left.count() as u64, Relaxed);
        self.counts.disk_bytes.store(self.folder.bytes(), Relaxed);
        match outcome {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::TimedOut => {
                tracing::debug!("another process holds the cache's folder for too long");
            }
            Err(error) => {
                self.failed = true;
                tracing::warn!(%error, folder = %self.folder.path().display(),
                    "the cache cannot be written: new payloads are kept in memory alone");
            }
        }
    }
}

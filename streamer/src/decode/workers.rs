//! The threads that decode: as many as there are processors, for all streamers of the process.
//!
//! They stand back for every other thread, so that a burst of data does not make frames late on machines
//! where the processor draws them, and for the threads that talk with the network.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::LazyLock;

use rayon::{ThreadPool, ThreadPoolBuilder};
use tokio::sync::oneshot;

use super::damaged;
use crate::StreamError;

/// How much nicer than others they are: beside one other thread on a processor they have a quarter of it.
#[cfg(target_os = "linux")]
const NICER: i32 = 5;

static WORKERS: LazyLock<ThreadPool> = LazyLock::new(|| {
    ThreadPoolBuilder::new()
        .thread_name(|index| format!("decoder {index}"))
        .start_handler(|_| stand_back())
        .build()
        .expect("a process may start threads")
});

/// The result of `decode`, which runs on one of the threads, first come, first served. A decoder that
/// panics on what it is given says that `what` is damaged: the crates that decode are not proof against
/// every byte.
///
/// # Errors
/// Those of `decode`, and [`StreamError::Damaged`] where it panics.
pub(crate) async fn decoded<T: Send + 'static>(
    what: &str,
    decode: impl FnOnce() -> Result<T, StreamError> + Send + 'static,
) -> Result<T, StreamError> {
    let (reply, result) = oneshot::channel();
    WORKERS.spawn_fifo(move || {
        if !reply.is_closed() {
            // What it has half done is dropped with it.
            drop(reply.send(catch_unwind(AssertUnwindSafe(decode))));
        }
    });
    match result.await {
        Ok(Ok(result)) => result,
        Ok(Err(_)) => Err(damaged(what, "its decoder gave up; fetch it again or ingest it anew")),
        // The process is going down.
        Err(_) => Err(StreamError::Cancelled),
    }
}

/// On Linux niceness is that of a thread; elsewhere it is of the whole process, and stays.
fn stand_back() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::nice(NICER) {
        tracing::debug!(%error, "decoders do not stand back");
    }
}

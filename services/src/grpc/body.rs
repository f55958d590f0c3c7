//! The body of an answer, watched: its bytes are counted, its status is noted, and it ends at the
//! call's deadline, also where its client takes nothing of it.
//!
//! HTTP/2 asks a body for more only when the client has room for more. A client that gives
//! none would keep what the body holds for as long as it likes, so something else than the body
//! must watch the clock.

use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker, ready};
use std::time::Duration;

use axum::body::Body;
use bytes::Bytes;
use http::HeaderMap;
use http_body::{Frame, SizeHint};
use tokio::task::AbortHandle;
use tokio::time::Instant;
use tonic::{Code, Status};

use super::call::Call;
use super::connections::Closer;

/// The body of a call's answer.
pub(super) struct CallBody {
    shared: Arc<Shared>,
    call: Call,
    watch: AbortHandle,
}

/// When a body ends though it has more to give.
#[derive(Clone)]
pub(super) struct Ending {
    /// The call's own deadline.
    pub(super) deadline: Option<Instant>,
    /// How long a client may take nothing.
    pub(super) patience: Duration,
    /// What closes the connection of a client that takes nothing for so long.
    pub(super) closer: Option<Closer>,
}

struct Shared {
    state: Mutex<State>,
}

struct State {
    body: Body,
    /// Since when the client could take more, and has not.
    offered: Option<Instant>,
    /// Who waits for the body.
    waker: Option<Waker>,
    /// The deadline has passed; the client is yet to be told.
    expired: bool,
    ended: bool,
}

impl CallBody {
    /// Must be called within a tokio runtime.
    pub(super) fn new(body: Body, call: Call, ending: Ending) -> Self {
        let state = State {
            body,
            offered: Some(Instant::now()),
            waker: None,
            expired: false,
            ended: false,
        };
        let shared = Arc::new(Shared { state: Mutex::new(state) });
        let watch = tokio::spawn(watch(Arc::clone(&shared), ending)).abort_handle();
        Self { shared, call, watch }
    }
}

/// Ends the body at its deadline, and the connection where its client takes nothing of it.
async fn watch(shared: Arc<Shared>, ending: Ending) {
    let mut deadline = ending.deadline;
    loop {
        let offered = shared.state().offered;
        let now = Instant::now();
        if offered.is_some_and(|offered| now >= offered + ending.patience) {
            tracing::debug!("a client takes nothing: its connection is closed");
            shared.state().body = Body::empty();
            if let Some(closer) = &ending.closer {
                closer.close();
            }
            return;
        }
        if deadline.is_some_and(|deadline| now >= deadline) {
            deadline = None;
            shared.expire();
        }
        let impatient = offered.unwrap_or(now) + ending.patience;
        let next = deadline.map_or(impatient, |deadline| deadline.min(impatient));
        tokio::time::sleep_until(next).await;
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn expire(&self) {
        let mut state = self.state();
        if state.ended {
            return;
        }
        let body = std::mem::take(&mut state.body);
        state.expired = true;
        let waker = state.waker.take();
        drop(state);
        // What it reads ends here.
        drop(body);
        if let Some(waker) = waker {
            waker.wake();
        }
    }
}

impl http_body::Body for CallBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let this = self.get_mut();
        let mut state = this.shared.state();
        if state.ended {
            return Poll::Ready(None);
        }
        state.offered = None;
        if state.expired {
            state.ended = true;
            this.call.code = Some(Code::DeadlineExceeded);
            let mut trailers = HeaderMap::new();
            // Only a message that is no header value could fail, and this one is.
            let _ = expired().add_header(&mut trailers);
            return Poll::Ready(Some(Ok(Frame::trailers(trailers))));
        }
        state.waker = Some(context.waker().clone());
        let frame = ready!(Pin::new(&mut state.body).poll_frame(context));
        state.offered = Some(Instant::now());
        match &frame {
            Some(Ok(frame)) => {
                if let Some(data) = frame.data_ref() {
                    this.call.bytes += data.len() as u64;
                }
                if let Some(trailers) = frame.trailers_ref() {
                    this.call.code = super::call::code(trailers);
                }
            }
            Some(Err(_)) => {}
            None => state.ended = true,
        }
        Poll::Ready(frame)
    }

    fn is_end_stream(&self) -> bool {
        let state = self.shared.state();
        state.ended || (!state.expired && state.body.is_end_stream())
    }

    fn size_hint(&self) -> SizeHint {
        // At the deadline the body ends early, so it promises nothing.
        SizeHint::default()
    }
}

impl Drop for CallBody {
    fn drop(&mut self) {
        self.watch.abort();
        // The watch may hold on to the body for a moment longer.
        let body = std::mem::take(&mut self.shared.state().body);
        drop(body);
    }
}

/// The status of a call whose deadline has passed.
pub(super) fn expired() -> Status {
    Status::deadline_exceeded("the deadline passed before the answer was complete")
}

//! When a server was last heard of. A message says nothing before it is whole, which on a slow connection takes
//! longer than a dead server may be waited for: so its bytes are listened to as they come.

use std::future::Future;
use std::pin::{Pin, pin};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use http::{Request, Response};
use http_body_util::BodyExt;
use tokio::time::{Instant, timeout_at};
use tonic::Status;
use tonic::body::Body;
use tonic::transport::{Channel, Error};
use tower::Service;

use crate::StreamError;

/// How long nothing at all may come before a call is given up.
const STALL: Duration = Duration::from_secs(15);
/// And how long nothing whole, while other calls are answered, or it comes drop by drop.
const CRAWL: Duration = Duration::from_secs(45);

/// When bytes of any call came last. Clones share it.
#[derive(Clone, Debug)]
pub(super) struct Heard(Arc<Mutex<Instant>>);

/// A channel that is listened to.
#[derive(Clone, Debug)]
pub(super) struct Listened {
    channel: Channel,
    heard: Heard,
}

impl Default for Heard {
    fn default() -> Self {
        Self(Arc::new(Mutex::new(Instant::now())))
    }
}

impl Heard {
    /// Listens to what comes through `channel`.
    pub(super) fn of(&self, channel: Channel) -> Listened {
        Listened { channel, heard: self.clone() }
    }

    /// What comes of `response`, unless the server falls silent.
    ///
    /// # Errors
    /// [`StreamError::Stalled`], and those of the call.
    pub(super) async fn in_time<T>(
        &self,
        call: &'static str,
        response: impl Future<Output = Result<T, Status>>,
    ) -> Result<T, StreamError> {
        let mut response = pin!(response);
        let begun = Instant::now();
        loop {
            let last = begun.max(self.last());
            let until = (last + STALL).min(begun + CRAWL);
            if let Ok(response) = timeout_at(until, &mut response).await {
                return response.map_err(StreamError::status(call));
            }
            if self.last() <= last || until == begun + CRAWL {
                return Err(StreamError::Stalled { call, seconds: (until - last).as_secs() });
            }
        }
    }

    /// When that was; at first, when listening began.
    pub(super) fn last(&self) -> Instant {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn note(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }
}

impl Service<Request<Body>> for Listened {
    type Response = Response<Body>;
    type Error = Error;
    type Future = Pin<Box<dyn Future<Output = Result<Response<Body>, Error>> + Send>>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Error>> {
        self.channel.poll_ready(context)
    }

    fn call(&mut self, request: Request<Body>) -> Self::Future {
        let (response, heard) = (self.channel.call(request), self.heard.clone());
        Box::pin(async move {
            let response = response.await?;
            heard.note();
            let listened = |body: Body| {
                Body::new(body.map_frame(move |frame| {
                    heard.note();
                    frame
                }))
            };
            Ok(response.map(listened))
        })
    }
}

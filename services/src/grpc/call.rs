//! What happens around every call: it is counted, logged, and ended at its deadline.
//!
//! tonic applies a deadline to the answer's head only; here it also ends the stream behind it.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll, ready};
use std::time::{Duration, Instant};

use axum::body::Body;
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;
use bytes::Bytes;
use http::header::CONTENT_TYPE;
use http::{HeaderMap, HeaderValue};
use http_body::{Frame, SizeHint};
use tokio::time::Sleep;
use tonic::{Code, Status};

use super::metrics::Metrics;

/// Counts and limits the calls of one server.
#[derive(Clone)]
pub(super) struct Calls {
    pub(super) metrics: Metrics,
    in_flight: Arc<AtomicUsize>,
    limit: usize,
}

impl Calls {
    /// At most `limit` calls at a time.
    pub(super) fn new(metrics: Metrics, limit: usize) -> Self {
        Self { metrics, in_flight: Arc::default(), limit }
    }
}

/// Answers a call through `next`; anything that is not gRPC passes through as it is.
pub(super) async fn around(State(calls): State<Calls>, request: Request, next: Next) -> Response {
    let is_grpc = request
        .headers()
        .get(CONTENT_TYPE)
        .is_some_and(|kind| kind.as_bytes().starts_with(b"application/grpc"));
    if !is_grpc {
        return next.run(request).await;
    }
    let mut call = Call::begin(calls, request.uri().path());
    if call.too_many {
        let status = Status::resource_exhausted("the server has too many calls; try again");
        call.code = Some(status.code());
        return refusal(&status);
    }
    let deadline = match timeout(request.headers()) {
        Ok(timeout) => timeout.map(tokio::time::sleep).map(Box::pin),
        Err(()) => {
            let status = Status::invalid_argument("grpc-timeout: is no duration");
            call.code = Some(status.code());
            return refusal(&status);
        }
    };
    let (deadline, response) = match deadline {
        None => (None, next.run(request).await),
        Some(mut deadline) => tokio::select! {
            response = next.run(request) => (Some(deadline), response),
            () = &mut deadline => {
                call.code = Some(Code::DeadlineExceeded);
                return refusal(&expired());
            }
        },
    };
    call.code = code(response.headers());
    response.map(|body| Body::new(CallBody { body, deadline, call, ended: false }))
}

/// A call in flight; counted when it is dropped.
struct Call {
    calls: Calls,
    method: String,
    started: Instant,
    bytes: u64,
    /// How it ended, once that is known.
    code: Option<Code>,
    too_many: bool,
}

impl Call {
    fn begin(calls: Calls, method: &str) -> Self {
        let others = calls.in_flight.fetch_add(1, Ordering::Relaxed);
        calls.metrics.begin();
        let too_many = others >= calls.limit;
        let method = method.to_owned();
        Self { calls, method, started: Instant::now(), bytes: 0, code: None, too_many }
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        self.calls.in_flight.fetch_sub(1, Ordering::Relaxed);
        // Without a status the client has gone away.
        let code = self.code.unwrap_or(Code::Cancelled);
        let duration = self.started.elapsed();
        self.calls.metrics.end(&self.method, code, duration, self.bytes);
        tracing::debug!(
            method = self.method,
            ?code,
            milliseconds = duration.as_secs_f64() * 1e3,
            bytes = self.bytes,
            "call"
        );
    }
}

/// A response's body, watched: bytes are counted, the status is noted, and at the deadline
/// what is left of it is dropped.
struct CallBody {
    body: Body,
    deadline: Option<Pin<Box<Sleep>>>,
    call: Call,
    ended: bool,
}

impl http_body::Body for CallBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let this = self.get_mut();
        if this.ended {
            return Poll::Ready(None);
        }
        if let Some(deadline) = &mut this.deadline
            && deadline.as_mut().poll(context).is_ready()
        {
            this.ended = true;
            this.body = Body::empty();
            this.call.code = Some(Code::DeadlineExceeded);
            let mut trailers = HeaderMap::new();
            // Only a message that is no header value could fail, and this one is.
            let _ = expired().add_header(&mut trailers);
            return Poll::Ready(Some(Ok(Frame::trailers(trailers))));
        }
        let frame = ready!(Pin::new(&mut this.body).poll_frame(context));
        if let Some(Ok(frame)) = &frame {
            if let Some(data) = frame.data_ref() {
                this.call.bytes += data.len() as u64;
            }
            if let Some(trailers) = frame.trailers_ref() {
                this.call.code = code(trailers);
            }
        }
        Poll::Ready(frame)
    }

    fn is_end_stream(&self) -> bool {
        self.ended || self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        // At the deadline the body ends early, so it promises nothing.
        SizeHint::default()
    }
}

/// The status among headers or trailers, where it is there.
fn code(headers: &HeaderMap) -> Option<Code> {
    headers.get(Status::GRPC_STATUS).map(|value| Code::from_bytes(value.as_bytes()))
}

fn expired() -> Status {
    Status::deadline_exceeded("the deadline passed before the answer was complete")
}

fn refusal(status: &Status) -> Response {
    status.clone().into_http()
}

/// The `grpc-timeout` header: at most eight digits and a unit.
fn timeout(headers: &HeaderMap) -> Result<Option<Duration>, ()> {
    let Some(value) = headers.get("grpc-timeout") else { return Ok(None) };
    let parse = |value: &HeaderValue| {
        let (unit, digits) = value.as_bytes().split_last()?;
        if digits.is_empty() || digits.len() > 8 || !digits.iter().all(u8::is_ascii_digit) {
            return None;
        }
        let count: u64 = std::str::from_utf8(digits).ok()?.parse().ok()?;
        Some(match unit {
            b'H' => Duration::from_secs(count * 3600),
            b'M' => Duration::from_secs(count * 60),
            b'S' => Duration::from_secs(count),
            b'm' => Duration::from_millis(count),
            b'u' => Duration::from_micros(count),
            b'n' => Duration::from_nanos(count),
            _ => return None,
        })
    };
    parse(value).map(Some).ok_or(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timeouts_are_read_as_the_specification_has_them() {
        let of = |text: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert("grpc-timeout", HeaderValue::from_static(text));
            timeout(&headers)
        };
        assert_eq!(timeout(&HeaderMap::new()), Ok(None));
        assert_eq!(of("250m"), Ok(Some(Duration::from_millis(250))));
        assert_eq!(of("99999999H"), Ok(Some(Duration::from_secs(99_999_999 * 3600))));
        for bad in ["", "S", "1", "-1S", "+1S", "100000000S", "1.5S", "1s", "1 S"] {
            assert_eq!(of(bad), Err(()), "{bad:?}");
        }
    }
}

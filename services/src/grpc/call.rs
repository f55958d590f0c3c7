//! What happens around every call: it is counted, logged, and ended at its deadline.
//!
//! tonic applies a deadline to the answer's head only; here it also ends the stream behind it.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::body::Body;
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;
use http::header::CONTENT_TYPE;
use http::{HeaderMap, HeaderValue};
use tokio::time::Instant;
use tonic::{Code, Status};

use super::body::{CallBody, Ending, expired};
use super::connections::Closer;
use super::metrics::Metrics;
use super::routes::Limits;
use super::status;

/// Counts and limits the calls of one server.
#[derive(Clone)]
pub(super) struct Calls {
    pub(super) metrics: Metrics,
    in_flight: Arc<AtomicUsize>,
    limit: usize,
    patience: Duration,
}

impl Calls {
    /// At most so many calls at a time as `limits` say, of clients that take what they ask for.
    pub(super) fn new(metrics: Metrics, limits: &Limits) -> Self {
        Self { metrics, in_flight: Arc::default(), limit: limits.calls, patience: limits.patience }
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
        let status = status::too_many_calls();
        call.code = Some(status.code());
        return refusal(&status);
    }
    let deadline = match timeout(request.headers()) {
        Ok(timeout) => timeout.and_then(|timeout| Instant::now().checked_add(timeout)),
        Err(()) => {
            let status = Status::invalid_argument("grpc-timeout: is no duration");
            call.code = Some(status.code());
            return refusal(&status);
        }
    };
    let closer = request.extensions().get::<Closer>().cloned();
    let response = match deadline {
        None => next.run(request).await,
        Some(deadline) => match tokio::time::timeout_at(deadline, next.run(request)).await {
            Ok(response) => response,
            Err(_) => {
                call.code = Some(Code::DeadlineExceeded);
                return refusal(&expired());
            }
        },
    };
    call.code = code(response.headers());
    let ending = Ending { deadline, patience: call.calls.patience, closer };
    response.map(|body| Body::new(CallBody::new(body, call, ending)))
}

/// A call in flight; counted when it is dropped.
pub(super) struct Call {
    calls: Calls,
    method: String,
    started: Instant,
    /// Bytes of its answer so far.
    pub(super) bytes: u64,
    /// How it ended, once that is known.
    pub(super) code: Option<Code>,
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

/// The status among headers or trailers, where it is there.
pub(super) fn code(headers: &HeaderMap) -> Option<Code> {
    headers.get(Status::GRPC_STATUS).map(|value| Code::from_bytes(value.as_bytes()))
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

//! What the services count, for Prometheus.

use std::sync::Arc;
use std::time::Duration;

use metrics::{counter, gauge, histogram};
use metrics_exporter_prometheus::{BuildError, PrometheusBuilder, PrometheusRecorder};
use tonic::Code;

/// Seconds that bound the buckets of the latency: from a cached answer to a long stream.
const LATENCY_BUCKETS_S: [f64; 14] =
    [0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 5.0, 30.0, 120.0];

/// The counters of one server. They are its own, not the process's.
#[derive(Clone)]
pub(super) struct Metrics {
    recorder: Arc<PrometheusRecorder>,
}

impl Metrics {
    pub(super) fn new() -> Result<Self, BuildError> {
        let recorder = PrometheusBuilder::new().set_buckets(&LATENCY_BUCKETS_S)?.build_recorder();
        let metrics = Self { recorder: Arc::new(recorder) };
        metrics.record(|| {
            metrics::describe_counter!(
                "flaneur_requests_total",
                "calls that ended, by method and code"
            );
            metrics::describe_histogram!(
                "flaneur_request_seconds",
                "from a call's start to the end of its stream"
            );
            metrics::describe_counter!(
                "flaneur_sent_bytes_total",
                "bytes of messages sent, by method"
            );
            metrics::describe_gauge!("flaneur_requests_in_flight", "calls that have not ended");
            gauge!("flaneur_requests_in_flight").set(0.0);
        });
        Ok(metrics)
    }

    /// A call began.
    pub(super) fn begin(&self) {
        self.record(|| gauge!("flaneur_requests_in_flight").increment(1.0));
    }

    /// A call ended, after `bytes` were sent.
    pub(super) fn end(&self, method: &str, code: Code, duration: Duration, bytes: u64) {
        // A client can call any method it likes; only ours may become labels.
        let method = if code == Code::Unimplemented { "unknown" } else { method }.to_owned();
        self.record(|| {
            gauge!("flaneur_requests_in_flight").decrement(1.0);
            counter!("flaneur_requests_total", "method" => method.clone(), "code" => name(code))
                .increment(1);
            counter!("flaneur_sent_bytes_total", "method" => method.clone()).increment(bytes);
            histogram!("flaneur_request_seconds", "method" => method).record(duration);
        });
    }

    /// Everything counted so far, in Prometheus's text format.
    pub(super) fn render(&self) -> String {
        self.recorder.handle().render()
    }

    /// Moves what was observed since into the histograms. To be called now and then: what
    /// nobody scrapes would pile up.
    pub(super) fn tidy(&self) {
        self.recorder.handle().run_upkeep();
    }

    fn record(&self, change: impl FnOnce()) {
        metrics::with_local_recorder(&*self.recorder, change);
    }
}

/// The code's name in the gRPC specification.
fn name(code: Code) -> &'static str {
    match code {
        Code::Ok => "OK",
        Code::Cancelled => "CANCELLED",
        Code::Unknown => "UNKNOWN",
        Code::InvalidArgument => "INVALID_ARGUMENT",
        Code::DeadlineExceeded => "DEADLINE_EXCEEDED",
        Code::NotFound => "NOT_FOUND",
        Code::AlreadyExists => "ALREADY_EXISTS",
        Code::PermissionDenied => "PERMISSION_DENIED",
        Code::ResourceExhausted => "RESOURCE_EXHAUSTED",
        Code::FailedPrecondition => "FAILED_PRECONDITION",
        Code::Aborted => "ABORTED",
        Code::OutOfRange => "OUT_OF_RANGE",
        Code::Unimplemented => "UNIMPLEMENTED",
        Code::Internal => "INTERNAL",
        Code::Unavailable => "UNAVAILABLE",
        Code::DataLoss => "DATA_LOSS",
        Code::Unauthenticated => "UNAUTHENTICATED",
    }
}

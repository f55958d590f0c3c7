//! The errors that a client of the render service sees.

use std::time::Duration;

use flaneur_renderer::RenderError;
use flaneur_streamer::StreamError;
use tonic::{Code, Status};
use tonic_types::{ErrorDetails, StatusExt};

/// When to try again what was one too many.
const RETRY: Duration = Duration::from_secs(2);

/// RESOURCE_EXHAUSTED where too many `things` are; with a hint when to try again.
pub(super) fn busy(things: &str) -> Status {
    let details = ErrorDetails::with_retry_info(Some(RETRY));
    let message =
        format!("the server is full: as many {things} as it takes; try again, or another");
    Status::with_error_details(Code::ResourceExhausted, message, details)
}

/// RESOURCE_EXHAUSTED for views that come too fast, and when the next may come.
pub(super) fn too_fast(views_per_s: u32, wait: Duration) -> Status {
    let details = ErrorDetails::with_retry_info(Some(wait));
    let message = format!("more than {views_per_s} views a second; send the latest only");
    Status::with_error_details(Code::ResourceExhausted, message, details)
}

/// What a failure to read the scene means.
pub(super) fn of_stream(error: &StreamError) -> Status {
    match error {
        StreamError::Status { status, .. } => {
            Status::with_details(status.code(), status.message(), status.details().to_vec().into())
        }
        StreamError::Stalled { .. } => Status::unavailable(error.to_string()),
        StreamError::Cancelled => Status::cancelled(error.to_string()),
        StreamError::BadMessage { .. }
        | StreamError::TooMuch { .. }
        | StreamError::Damaged { .. }
        | StreamError::Cache(_) => Status::data_loss(error.to_string()),
    }
}

/// What a failure to render means.
pub(super) fn of_render(error: &RenderError) -> Status {
    match error {
        RenderError::ViewSize { .. } | RenderError::ViewCamera { .. } => {
            Status::invalid_argument(error.to_string())
        }
        RenderError::ViewMemory { .. } => Status::resource_exhausted(error.to_string()),
        RenderError::NoAdapter
        | RenderError::Device { .. }
        | RenderError::DeviceMemory
        | RenderError::Driver(_) => {
            tracing::error!(%error, "the driver fails");
            Status::unavailable(error.to_string())
        }
        _ => {
            tracing::error!(%error, "a frame cannot be rendered");
            Status::internal(error.to_string())
        }
    }
}

//! Every error that a client sees is made here.
//!
//! Names and fields of the request come back to the client; paths, URLs and messages of the
//! store do not: they go to the log. What is worth another try carries a `google.rpc.RetryInfo`,
//! and nothing else does.

use std::time::Duration;

use flaneur_proto::FieldError;
use tonic::{Code, Status};
use tonic_types::{ErrorDetails, StatusExt};

use crate::layers::LayerError;
use crate::store::StoreError;

/// When a call may be tried again that was one too many: calls take milliseconds.
const RETRY_CALLS: Duration = Duration::from_millis(250);

/// When a call may be tried again after the store failed: it has been tried several times.
const RETRY_STORE: Duration = Duration::from_secs(1);

/// INVALID_ARGUMENT that names the field, in words and as `google.rpc.BadRequest`.
pub(crate) fn invalid(error: &FieldError) -> Status {
    let details = ErrorDetails::with_bad_request_violation(&error.field, &error.problem);
    Status::with_error_details(Code::InvalidArgument, error.to_string(), details)
}

/// INVALID_ARGUMENT for a request with more keys than are taken.
pub(super) fn too_many(field: &str, count: usize, limit: usize) -> Status {
    invalid(&FieldError::new(field, format!("holds {count} keys, at most {limit} are taken")))
}

/// NOT_FOUND that names what is missing and where it was looked for.
pub(super) fn not_found(kind: &str, name: impl std::fmt::Display, place: &str) -> Status {
    let details = ErrorDetails::with_resource_info(kind, name.to_string(), "", "");
    Status::with_error_details(Code::NotFound, format!("no {kind} {name} in {place}"), details)
}

/// RESOURCE_EXHAUSTED for something that is larger than the service hands out.
pub(super) fn too_large(what: &str, bytes: usize, limit: usize) -> Status {
    Status::resource_exhausted(format!("{what} takes {bytes} bytes, more than {limit}"))
}

/// RESOURCE_EXHAUSTED for a call that comes while the server has too many; with a hint when to
/// try again.
pub(super) fn too_many_calls() -> Status {
    let details = ErrorDetails::with_retry_info(Some(RETRY_CALLS));
    let message = "the server has too many calls; try again";
    Status::with_error_details(Code::ResourceExhausted, message, details)
}

/// UNAVAILABLE for what may go well the next time; with a hint when to try again.
pub(super) fn try_again(problem: &str) -> Status {
    let details = ErrorDetails::with_retry_info(Some(RETRY_STORE));
    Status::with_error_details(Code::Unavailable, format!("{problem}; try again"), details)
}

/// The status of a failure to find or open a scene.
pub(super) fn of_store(error: &StoreError) -> Status {
    match error {
        StoreError::NoScene { name } => {
            let details = ErrorDetails::with_resource_info("scene", name, "", "");
            let message = format!("no scene is named {name:?}; ListScenes gives the names");
            Status::with_error_details(Code::NotFound, message, details)
        }
        StoreError::BadSceneName { name, problem } => {
            invalid(&FieldError::new("scene", format!("is {name:?}: {problem}")))
        }
        StoreError::BadManifest { scene, .. } => {
            tracing::error!(%error, "scene cannot be read");
            damaged(&format!("scene {scene:?}"))
        }
        StoreError::Damaged { .. } => {
            tracing::error!(%error, "object cannot be read");
            damaged("an object of the scene")
        }
        StoreError::Object { source } => of_object_store("the scenes", source),
        _ => {
            tracing::error!(%error, "store cannot be read");
            Status::internal("the store cannot be read; the server's log says why")
        }
    }
}

/// The status of a failure to read `layer` of a scene.
pub(super) fn of_layer(layer: &str, error: &LayerError) -> Status {
    if let LayerError::Store(source) = error {
        return of_object_store(layer, source);
    }
    tracing::error!(%error, layer, "layer cannot be read");
    damaged(layer)
}

/// The status of something in `layer` that cannot be sent.
pub(super) fn of_field(layer: &str, error: &FieldError) -> Status {
    tracing::error!(%error, layer, "layer cannot be sent");
    damaged(layer)
}

/// The status of a failure of the store while `what` was read.
pub(super) fn of_object_store(what: &str, error: &object_store::Error) -> Status {
    if let object_store::Error::NotFound { .. } = error {
        tracing::error!(%error, what, "object is missing");
        return damaged(what);
    }
    tracing::warn!(%error, what, "store failed");
    try_again(&format!("the store did not give {what}"))
}

fn damaged(what: &str) -> Status {
    Status::data_loss(format!("{what} cannot be read; the server's log says why"))
}

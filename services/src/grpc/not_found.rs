//! What is said to requests that are neither for a page nor calls.

use axum::extract::Request;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use http::StatusCode;
use http::header::CONTENT_TYPE;

/// Of the services that there are: those of this program, health checks and reflection.
const PACKAGES: [&str; 2] = ["flaneur.v1.", "grpc."];

const NOT_FOUND: &str = "there is nothing here; / says what there is\n";
const NOT_A_CALL: &str = "this is a method of gRPC and gRPC-Web: call it by POST, as application/grpc or application/grpc-web\n";

/// Lets calls through; anything else is not found, or is no call. Without it gRPC's own layers would
/// answer 400 to it, or an empty 200.
pub(super) async fn around(request: Request, next: Next) -> Response {
    let kind = request.headers().get(CONTENT_TYPE);
    if kind.is_some_and(|kind| kind.as_bytes().starts_with(b"application/grpc")) {
        return next.run(request).await;
    }
    if is_method(request.uri().path()) {
        return (StatusCode::UNSUPPORTED_MEDIA_TYPE, NOT_A_CALL).into_response();
    }
    (StatusCode::NOT_FOUND, NOT_FOUND).into_response()
}

/// Whether a path is in a service of this program, or in one of gRPC's own.
fn is_method(path: &str) -> bool {
    let service = path.strip_prefix('/').and_then(|path| path.split_once('/'));
    service.is_some_and(|(service, _)| PACKAGES.iter().any(|package| service.starts_with(package)))
}

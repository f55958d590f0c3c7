//! The web page, as `services/web` was built: its files are in the binary.

use std::borrow::Cow;

use axum::Router;
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::response::IntoResponse;
use axum::routing::get;
use rust_embed::{Embed, EmbeddedFile};
use tower_http::compression::CompressionLayer;

/// The page's files. There are none where it was not built before the binary was.
#[derive(Embed)]
#[folder = "web/dist"]
#[allow_missing = true]
struct Files;

/// The file that stands for the whole.
const INDEX: &str = "index.html";
/// Files below have their content's hash in their names.
const HASHED: &str = "assets/";

/// What the page may load: nothing that this server does not have.
const POLICY: &str = "default-src 'self'; img-src 'self' blob: data:; worker-src 'self' blob:; \
                      style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri 'none'";

/// Whether the binary has the page.
pub(crate) fn is_there() -> bool {
    Files::get(INDEX).is_some()
}

/// A route for every file, and `/` for the page itself, too.
pub(crate) fn routes() -> Router {
    let mut router = Router::new().route("/", get(async || file(INDEX)));
    for path in Files::iter() {
        router = router.route(&format!("/{path}"), get(async move || file(&path)));
    }
    router.layer(CompressionLayer::new())
}

fn file(path: &str) -> impl IntoResponse + use<> {
    let data = Files::get(path).map_or(Cow::Borrowed(&[][..]), |file: EmbeddedFile| file.data);
    let kept = if path.starts_with(HASHED) { "max-age=31536000, immutable" } else { "no-cache" };
    let headers = [
        (CONTENT_TYPE, media_type(path)),
        (CACHE_CONTROL, kept),
        (CONTENT_SECURITY_POLICY, POLICY),
    ];
    (headers, data)
}

fn media_type(path: &str) -> &'static str {
    match path.rsplit_once('.').map(|(_, extension)| extension) {
        Some("html") => "text/html; charset=utf-8",
        Some("js" | "mjs") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("ico") => "image/x-icon",
        Some("woff2") => "font/woff2",
        Some("json" | "map" | "webmanifest") => "application/json",
        Some("txt") => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

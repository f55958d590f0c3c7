//! Pages of other servers that may call.
//!
//! Browsers let a page call the server that it came from, and any other only where that one admits it.
//! Who reaches this server may have it open in the same browser as pages of strangers, which must not
//! read a survey through it: so none is admitted unless someone says which.

use std::str::FromStr;
use std::time::Duration;

use http::Method;
use http::header::{HeaderName, HeaderValue};
use tower_http::cors::{AllowOrigin, Any, CorsLayer};
use url::Url;

/// Where pages come from that may call, beside the server's own page, which needs no leave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Wherever they come from.
    Any,
    /// A scheme, a host and a port, as browsers write them.
    One(HeaderValue),
}

/// What was given as an origin and is none.
#[derive(Debug, thiserror::Error)]
#[error("is not where pages come from: write https://host or http://host:port, or * for all")]
pub struct NoOrigin;

impl FromStr for Origin {
    type Err = NoOrigin;

    fn from_str(text: &str) -> Result<Self, NoOrigin> {
        if text == "*" {
            return Ok(Self::Any);
        }
        let url = Url::parse(text).map_err(|_| NoOrigin)?;
        let origin = url.origin().ascii_serialization();
        // Nothing but the origin, however it was written.
        if !matches!(url.scheme(), "http" | "https") || url.as_str() != format!("{origin}/") {
            return Err(NoOrigin);
        }
        HeaderValue::from_str(&origin).map(Self::One).map_err(|_| NoOrigin)
    }
}

/// Tells browsers which pages may call, and what they may see of the answers.
pub(super) fn layer(origins: &[Origin]) -> CorsLayer {
    let listed = origins.iter().filter_map(|origin| match origin {
        Origin::Any => None,
        Origin::One(origin) => Some(origin.clone()),
    });
    let allowed =
        if origins.contains(&Origin::Any) { AllowOrigin::any() } else { AllowOrigin::list(listed) };
    let exposed = ["grpc-status", "grpc-message", "grpc-status-details-bin"];
    CorsLayer::new()
        .allow_origin(allowed)
        .allow_methods([Method::GET, Method::POST])
        .allow_headers(Any)
        .expose_headers(exposed.map(HeaderName::from_static))
        .max_age(Duration::from_secs(24 * 3600))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_origin_is_what_browsers_say_of_a_page() {
        let read = |text: &str| text.parse::<Origin>().ok();
        let one = |text: &'static str| Some(Origin::One(HeaderValue::from_static(text)));
        assert_eq!(read("*"), Some(Origin::Any));
        assert_eq!(read("https://Maps.example.org:443"), one("https://maps.example.org"));
        assert_eq!(read("http://[::1]:5173/"), one("http://[::1]:5173"));
        for bad in ["", "maps.example.org", "https://a.org/street", "https://me@a.org", "file:///a"]
        {
            assert_eq!(read(bad), None, "{bad:?}");
        }
    }
}

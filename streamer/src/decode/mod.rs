//! From the bytes of the store to what a renderer takes, on threads that may block.

mod colour;
mod cube;
mod feather;
mod laz;
mod mask;
mod normals;
mod order;
mod picture;
mod points;
mod spacing;
mod stations;
mod surveyed;

use std::sync::Arc;

use tokio::sync::Semaphore;

pub(crate) use cube::cube_face;
pub(crate) use mask::{Mask, decode_mask};
pub(crate) use picture::{Picture, decode_picture};
pub(crate) use points::decode_points;
pub(crate) use stations::Track;
pub use surveyed::SurveyedPoint;
pub(crate) use surveyed::nearest_point;

use crate::StreamError;

/// Runs decoders beside the async threads, as many at once as there are processors.
#[derive(Clone, Debug)]
pub(crate) struct Decoders {
    free: Arc<Semaphore>,
}

impl Default for Decoders {
    fn default() -> Self {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        Self { free: Arc::new(Semaphore::new(processors)) }
    }
}

impl Decoders {
    /// The result of `decode`. A decoder that panics on what it is given says that `what` is
    /// damaged: the crates that decode are not proof against every byte.
    pub(crate) async fn run<T: Send + 'static>(
        &self,
        what: &str,
        decode: impl FnOnce() -> Result<T, StreamError> + Send + 'static,
    ) -> Result<T, StreamError> {
        let permit = Arc::clone(&self.free).acquire_owned().await;
        let permit = permit.expect("the semaphore is never closed");
        let decoded = tokio::task::spawn_blocking(move || {
            let _permit = permit;
            decode()
        });
        match decoded.await {
            Ok(result) => result,
            Err(error) if error.is_panic() => {
                Err(damaged(what, "its decoder gave up; fetch it again or ingest it anew"))
            }
            // The runtime is going down.
            Err(_) => Err(StreamError::Cancelled),
        }
    }
}

pub(crate) fn damaged(what: impl Into<String>, problem: impl Into<String>) -> StreamError {
    StreamError::Damaged { what: what.into(), problem: problem.into() }
}

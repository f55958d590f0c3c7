//! What a caller wants to see.

use std::fmt;
use std::sync::Arc;

use flaneur_scene::{ImageId, View};

use crate::FetchLimits;

/// A view, and what may be used for it.
#[derive(Clone)]
pub struct ViewRequest {
    /// The view.
    pub view: View,
    /// The limits.
    pub limits: FetchLimits,
    /// Which photographs must not be used.
    pub excluded: Arc<dyn Fn(&ImageId) -> bool + Send + Sync>,
    /// Whether points come with normals, estimated as they arrive: some 0.2 µs a point, beside
    /// what decoding takes.
    pub normals: bool,
}

impl ViewRequest {
    /// A request for `view` within the default limits, from all photographs and points as
    /// they are stored.
    pub fn new(view: View) -> Self {
        let excluded = Arc::new(|_: &ImageId| false);
        Self { view, limits: FetchLimits::default(), excluded, normals: false }
    }
}

impl fmt::Debug for ViewRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ViewRequest")
            .field("view", &self.view)
            .field("limits", &self.limits)
            .field("normals", &self.normals)
            .finish_non_exhaustive()
    }
}

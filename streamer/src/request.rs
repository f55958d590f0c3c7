//! What a caller wants to see.

use std::fmt;
use std::sync::Arc;

use flaneur_scene::{ImageId, View};

use crate::Budget;

/// A view, and what may be used for it.
#[derive(Clone)]
pub struct ViewRequest {
    /// The view.
    pub view: View,
    /// The limits.
    pub budget: Budget,
    /// Which photographs must not be used.
    pub excluded: Arc<dyn Fn(&ImageId) -> bool + Send + Sync>,
}

impl ViewRequest {
    /// A request for `view` within the default budget, from all photographs.
    pub fn new(view: View) -> Self {
        Self { view, budget: Budget::default(), excluded: Arc::new(|_| false) }
    }
}

impl fmt::Debug for ViewRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ViewRequest")
            .field("view", &self.view)
            .field("budget", &self.budget)
            .finish_non_exhaustive()
    }
}

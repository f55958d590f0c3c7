//! What a caller wants to see.

use std::fmt;
use std::sync::Arc;

use flaneur_scene::{ImageId, View};
use glam::DVec2;

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
    /// Where someone looks.
    pub gaze: Gaze,
    /// How much more what the receiver holds counts than what it does not, at least 1. Above 1
    /// nothing comes and goes while a view wavers about a threshold, and what is held
    /// then depends on what was held before.
    pub steadiness: f64,
}

/// Where someone looks: beside it coarser points serve, half as dense at the distance of a
/// corner from the centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Gaze {
    /// Everywhere alike, as in a picture that is kept.
    #[default]
    Everywhere,
    /// At the centre of the picture.
    Centre,
    /// At a pixel.
    At(DVec2),
}

impl ViewRequest {
    /// Of what is held, for people who walk: see [`ViewRequest::steadiness`].
    pub const STEADY: f64 = 1.25;

    /// A request for `view` within the default limits, from all photographs and points as
    /// they are stored, for a picture that the view alone determines.
    pub fn new(view: View) -> Self {
        let excluded = Arc::new(|_: &ImageId| false);
        Self {
            view,
            limits: FetchLimits::default(),
            excluded,
            normals: false,
            gaze: Gaze::Everywhere,
            steadiness: 1.0,
        }
    }

    /// A request for what someone sees who walks about: the centre counts most, and what is there
    /// stays while it may.
    pub fn walking(view: View) -> Self {
        Self { gaze: Gaze::Centre, steadiness: Self::STEADY, ..Self::new(view) }
    }
}

impl Gaze {
    /// Whether what is beside it counts less.
    pub(crate) fn weighs(self) -> bool {
        self != Self::Everywhere
    }

    /// Its pixel, `None` for the centre.
    pub(crate) fn pixel(self) -> Option<DVec2> {
        match self {
            Self::At(pixel) => Some(pixel),
            Self::Everywhere | Self::Centre => None,
        }
    }
}

impl fmt::Debug for ViewRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ViewRequest")
            .field("view", &self.view)
            .field("limits", &self.limits)
            .field("normals", &self.normals)
            .field("gaze", &self.gaze)
            .field("steadiness", &self.steadiness)
            .finish_non_exhaustive()
    }
}

//! How much of a picture shows nothing of a survey.

use flaneur_renderer::FrameStats;

/// Parts of a picture's pixels, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Shows neither mesh nor points: the sky, and what nobody surveyed ...
    pub unsurveyed: f64,
    /// ... of which photographs tell nothing either: mere background.
    pub blank: f64,
}

impl Shares {
    /// Those of a frame; none of one without pixels.
    pub fn of(stats: &FrameStats) -> Self {
        let unsurveyed = stats.pixels.saturating_sub(stats.geometry_pixels);
        let blank = unsurveyed.saturating_sub(stats.inferred_pixels + stats.completed_pixels);
        let [unsurveyed, blank] =
            [unsurveyed, blank].map(|pixels| pixels as f64 / stats.pixels.max(1) as f64);
        Self { unsurveyed, blank }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_inferred_is_not_surveyed_but_not_blank_either() {
        let stats = FrameStats {
            pixels: 100,
            geometry_pixels: 60,
            inferred_pixels: 20,
            completed_pixels: 10,
            ..FrameStats::default()
        };
        assert_eq!(Shares::of(&stats), Shares { unsurveyed: 0.4, blank: 0.1 });
        let none = Shares { unsurveyed: 0.0, blank: 0.0 };
        assert_eq!(Shares::of(&FrameStats::default()), none);
    }
}

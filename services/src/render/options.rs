//! How much a render service takes on, and how it renders.

use std::time::Duration;

use flaneur_renderer::Settings;
use flaneur_streamer::FetchLimits;

/// Choices of a render service.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// With what final frames are rendered. The memory on the device is that of each scene.
    pub settings: Settings,
    /// What a view may ask for.
    pub limits: FetchLimits,
    /// What a frame takes, about, while its view moves.
    pub budget: Duration,
    /// Most pixels of a picture.
    pub pixels: u64,
    /// Most sessions, and most pictures that are waited for, at a time.
    pub sessions: usize,
    /// Most scenes on the device at a time.
    pub scenes: usize,
    /// How long a session may say nothing before it ends.
    pub idle: Duration,
    /// Most views a second of one session.
    pub views_per_s: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            settings: Settings::default(),
            limits: FetchLimits::default(),
            budget: Duration::from_millis(100),
            pixels: 1 << 21,
            sessions: 64,
            scenes: 4,
            idle: Duration::from_secs(600),
            views_per_s: 240,
        }
    }
}

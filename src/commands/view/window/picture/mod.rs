//! The street behind everything else in the window: the newest frame, brought to where one looks now by
//! the homography between its view and the present one, beneath it a few older ones for where it does
//! not reach, and behind all its mere colours.

mod colours;
mod layer;
mod reprojection;

use flaneur_renderer::Mode;
use flaneur_scene::View;
use glam::DMat3;

use crate::commands::view::painter::Shown;
use layer::{Drawing, Layer};
use reprojection::{covers, screen_from_frame};

/// Frames that are kept at most.
const MOST_FRAMES: usize = 4;
/// From farther away an older frame is no help, metres.
const REACH: f64 = 4.0;

/// Draws it.
#[derive(Debug)]
pub(super) struct Picture {
    frame: Drawing,
    backdrop: Drawing,
    /// The newest last.
    frames: Vec<Frame>,
    /// Those that serve no more.
    spare: Vec<Layer>,
    colours: Layer,
}

/// What is shown.
#[derive(Debug)]
struct Frame {
    view: View,
    mode: Mode,
    layer: Layer,
}

impl Picture {
    /// Nothing yet, for targets of `format`.
    pub(super) fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let drawing = |label, wgsl| Drawing::new(device, label, wgsl, format);
        let backdrop = drawing("backdrop", include_str!("backdrop.wgsl"));
        Self {
            frame: drawing("frame", include_str!("frame.wgsl")),
            colours: backdrop.layer(device, colours::SIZE),
            backdrop,
            frames: Vec::new(),
            spare: Vec::new(),
        }
    }

    /// Shows a new frame from now on.
    pub(super) fn show(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, shown: &Shown) {
        let useless = |older: &mut Frame| {
            let map = screen_from_frame(&shown.view, &older.view);
            older.mode != shown.mode
                || older.view.eye().distance(shown.view.eye()) > REACH
                || covers(&map, shown.size, older.layer.size)
        };
        let left = self.frames.extract_if(.., useless).map(|frame| frame.layer);
        self.spare.extend(left);
        if self.frames.len() == MOST_FRAMES {
            self.spare.push(self.frames.remove(0).layer);
        }
        self.spare.retain(|layer| layer.size == shown.size);
        let layer = self.spare.pop().unwrap_or_else(|| self.frame.layer(device, shown.size));
        layer.fill(queue, &shown.rgba);
        self.colours.fill(queue, &colours::colours(&shown.rgba, shown.size));
        self.frames.push(Frame { view: shown.view, mode: shown.mode, layer });
    }

    /// Forgets it, as where it shows another scene.
    pub(super) fn clear(&mut self) {
        (self.frames, self.spare) = (Vec::new(), Vec::new());
    }

    /// Draws it as `screen` would see it; nothing before the first frame.
    pub(super) fn draw(&self, queue: &wgpu::Queue, pass: &mut wgpu::RenderPass<'_>, screen: &View) {
        let maps: Vec<DMat3> =
            self.frames.iter().map(|frame| screen_from_frame(&frame.view, screen)).collect();
        let with_maps = || self.frames.iter().zip(&maps);
        // What lies beneath one that fills the window is not to be seen.
        let filling =
            with_maps().rposition(|(frame, map)| covers(map, frame.layer.size, screen.size()));
        if let (None, Some((newest, map))) = (filling, with_maps().next_back()) {
            let sizes = [newest.layer.size, screen.size()];
            self.backdrop.draw(queue, pass, &self.colours, &map.inverse(), sizes);
        }
        for (frame, map) in with_maps().skip(filling.unwrap_or(0)) {
            let sizes = [frame.layer.size, screen.size()];
            self.frame.draw(queue, pass, &frame.layer, &map.inverse(), sizes);
        }
    }
}

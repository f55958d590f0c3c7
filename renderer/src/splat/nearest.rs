//! What each pixel keeps of the points that it shows.

use glam::UVec2;

use crate::Gpu;

/// How the nearest of a pixel's points is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Route {
    /// Depth and index in one word, in one phase.
    Atomic64,
    /// Depth and index in a word each, in two phases.
    Atomic32,
}

/// Depth and index of a pixel's nearest point, all bits set where there is none.
#[derive(Debug)]
pub(crate) struct Nearest {
    route: Route,
    words: wgpu::Buffer,
    pixels: u64,
}

impl Nearest {
    pub(crate) fn new(gpu: &Gpu, size: UVec2, route: Route) -> Self {
        let pixels = u64::from(size.x) * u64::from(size.y);
        let words = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("nearest points"),
            size: 2 * half(pixels),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Self { route, words, pixels }
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.words.size()
    }

    pub(crate) fn route(&self) -> Route {
        self.route
    }

    /// All words, to be emptied: in two halves, since the whole may be more than a binding can be.
    pub(super) fn words(&self) -> [wgpu::BufferBinding<'_>; 2] {
        let half = half(self.pixels);
        [self.part(0, half), self.part(half, half)]
    }

    /// What the route's shader writes.
    pub(super) fn bindings(&self) -> Vec<wgpu::BufferBinding<'_>> {
        match self.route {
            Route::Atomic64 => vec![self.part(0, 8 * self.pixels)],
            Route::Atomic32 => vec![self.part(0, 4 * self.pixels), self.indices().0],
        }
    }

    /// Words among which every so many is an index, beginning with the first.
    pub(crate) fn indices(&self) -> (wgpu::BufferBinding<'_>, u32) {
        match self.route {
            // The lower half of a word of 64 bits comes first.
            Route::Atomic64 => (self.part(0, 8 * self.pixels), 2),
            Route::Atomic32 => (self.part(half(self.pixels), 4 * self.pixels), 1),
        }
    }

    fn part(&self, offset: u64, bytes: u64) -> wgpu::BufferBinding<'_> {
        wgpu::BufferBinding { buffer: &self.words, offset, size: std::num::NonZero::new(bytes) }
    }

    /// Bits of depth and index of each pixel, from the whole buffer as it is copied out.
    #[cfg(test)]
    pub(crate) fn pairs(&self, gpu: &Gpu) -> Vec<(u32, u32)> {
        let encoder = gpu.device.create_command_encoder(&Default::default());
        let words: Vec<u32> = crate::kernel_tests::read(encoder, &self.words);
        let pixels = self.pixels as usize;
        match self.route {
            Route::Atomic64 => words.chunks_exact(2).take(pixels).map(|w| (w[1], w[0])).collect(),
            Route::Atomic32 => {
                let indices = &words[half(self.pixels) as usize / 4..];
                words.iter().copied().zip(indices.iter().copied()).take(pixels).collect()
            }
        }
    }
}

/// Bytes of one word a pixel, up to where a binding may start.
fn half(pixels: u64) -> u64 {
    (4 * pixels).next_multiple_of(256)
}

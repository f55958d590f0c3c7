//! What a way of texturing costs in memory.

use glam::UVec2;

use super::CORNERS;
use crate::settings::Texturing;

/// Bytes that a way of texturing points takes, beyond what all of them take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexturingMemory {
    /// Held on the device between frames.
    pub buffers: u64,
    /// Vertices of one sprite in one photograph. Devices of today have no points of more than a
    /// pixel, so that both ways draw a strip of four where the poster has one and four.
    pub vertices_a_sprite: u32,
    /// What one such vertex hands to the pixels, without its position.
    pub varyings_a_vertex: u32,
}

impl TexturingMemory {
    /// For a picture of `size` and `points` that are drawn: all of the resident chunks that the
    /// view meets.
    pub fn new(texturing: Texturing, size: UVec2, points: u64) -> Self {
        let bytes = Bytes::of_frame(u64::from(size.x) * u64::from(size.y), points);
        let buffers = bytes.total();
        match texturing {
            Texturing::Deferred => Self { buffers: 0, vertices_a_sprite: 0, varyings_a_vertex: 0 },
            Texturing::Homography => {
                Self { buffers, vertices_a_sprite: CORNERS, varyings_a_vertex: 64 }
            }
            Texturing::Barycentric => {
                Self { buffers, vertices_a_sprite: CORNERS, varyings_a_vertex: 28 }
            }
        }
    }

    /// Bytes that pass between the stages for one sprite in one photograph.
    pub fn varyings_a_sprite(&self) -> u32 {
        self.vertices_a_sprite * self.varyings_a_vertex
    }
}

/// Sizes of the buffers of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bytes {
    /// A word a point.
    pub(crate) homes: u64,
    /// Three words a pixel.
    pub(crate) reaches: u64,
    /// A word a pixel: no pixel has more than one sprite.
    pub(crate) sprites: u64,
}

impl Bytes {
    pub(crate) fn of_frame(pixels: u64, points: u64) -> Self {
        Self { homes: 4 * points.max(1), reaches: 12 * pixels, sprites: 4 * pixels }
    }

    pub(crate) fn total(&self) -> u64 {
        self.homes + self.reaches + self.sprites
    }

    pub(crate) fn largest(&self) -> u64 {
        self.homes.max(self.reaches).max(self.sprites)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forward::sprites_wgsl;

    /// Bytes of what the vertex stage hands on, its position apart, as the shader has it.
    fn varyings(texturing: Texturing) -> Option<u32> {
        let module = naga::front::wgsl::parse_str(&sprites_wgsl(texturing)?).expect("valid");
        let vertex = module
            .entry_points
            .iter()
            .find(|entry| entry.name == "sprite_vs")
            .and_then(|entry| entry.function.result.as_ref())
            .expect("a vertex stage");
        let naga::TypeInner::Struct { members, .. } = &module.types[vertex.ty].inner else {
            panic!("the vertex stage gives a struct")
        };
        let located = members
            .iter()
            .filter(|member| matches!(member.binding, Some(naga::Binding::Location { .. })));
        Some(located.map(|member| module.types[member.ty].inner.size(module.to_ctx())).sum())
    }

    #[test]
    fn varyings_are_those_of_the_shaders() {
        for texturing in Texturing::ALL {
            let memory = TexturingMemory::new(texturing, UVec2::new(1024, 512), 1_000_000);
            assert_eq!(memory.varyings_a_vertex, varyings(texturing).unwrap_or(0), "{texturing:?}");
        }
    }
}

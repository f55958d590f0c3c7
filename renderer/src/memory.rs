//! How much of the device's memory a renderer holds, and may hold.

use flaneur_scene::SceneUpdate;

/// Bytes of buffers and textures that are kept between frames, by what they hold. What a frame
/// needs for itself alone (lists of what is drawn, uniforms) is not among them, nor are the grids of
/// inference and alignment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryReport {
    /// Pages of points, whether in use or free.
    pub points: u64,
    /// Tiles of mesh.
    pub mesh: u64,
    /// Texture arrays of photographs with their levels, whether in use or free.
    pub photographs: u64,
    /// The photographs' depth maps.
    pub depth_maps: u64,
    /// What a picture of the last size is drawn into.
    pub targets: u64,
}

impl MemoryReport {
    /// All of it.
    pub fn total(&self) -> u64 {
        let Self { points, mesh, photographs, depth_maps, targets } = *self;
        points + mesh + photographs + depth_maps + targets
    }
}

/// How much of the memory each kind may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shares {
    pub(crate) photographs: u64,
    pub(crate) points: u64,
    pub(crate) depth_maps: u64,
    pub(crate) mesh: u64,
}

impl Shares {
    /// Of `total` bytes; pictures have what is left.
    pub(crate) fn of(total: u64) -> Self {
        let sixteenth = total / 16;
        Self {
            photographs: 6 * sixteenth,
            points: 3 * sixteenth,
            depth_maps: 2 * sixteenth,
            mesh: sixteenth,
        }
    }
}

/// What became of an update.
#[derive(Clone, Debug, Default)]
pub struct Applied {
    /// What is not resident any more to make room, as the updates that would have dropped it.
    /// Whoever keeps account of what is resident must be told.
    pub evicted: Vec<SceneUpdate>,
    /// Whether the update itself found no room: all else is more useful. What it was to replace is
    /// gone, too, and among the evicted.
    pub refused: bool,
}

/// Bytes of a texture with all its layers and levels, without what a driver adds.
pub(crate) fn of_texture(texture: &wgpu::Texture) -> u64 {
    let level = |level| {
        let size = texture.size().mip_level_size(level, texture.dimension());
        texture.format().theoretical_memory_footprint(size)
    };
    (0..texture.mip_level_count()).map(level).sum()
}

//! How much of the device's memory a renderer holds, and may hold.

use flaneur_scene::{ImageId, SceneUpdate};

/// Bytes of buffers and textures that are kept between frames, by what they hold. What is made anew
/// for every frame and given back after it (lists of what is drawn, uniforms) is not among them: 32
/// bytes for every 256 points, and some eight for every photograph and tile of 32×32 pixels.
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
    /// The list of discs that are drawn as quads.
    pub large_discs: u64,
    /// What a picture of the last size is drawn into.
    pub targets: u64,
    /// The grids on which depths are inferred, and colours completed.
    pub inference: u64,
    /// The grids on which photographs are aligned.
    pub alignment: u64,
    /// Sprites of points, where those are not textured by the deferred way.
    pub sprites: u64,
    /// What exposure gains are measured with.
    pub gains: u64,
}

impl MemoryReport {
    /// All of it.
    pub fn total(&self) -> u64 {
        self.kinds().iter().map(|(_, bytes)| bytes).sum()
    }

    /// Each kind's name and bytes.
    pub fn kinds(&self) -> [(&'static str, u64); 10] {
        let Self { points, mesh, photographs, depth_maps, large_discs, .. } = *self;
        let Self { targets, inference, alignment, sprites, gains, .. } = *self;
        [
            ("points", points),
            ("mesh", mesh),
            ("photographs", photographs),
            ("depth_maps", depth_maps),
            ("large_discs", large_discs),
            ("targets", targets),
            ("inference", inference),
            ("alignment", alignment),
            ("sprites", sprites),
            ("gains", gains),
        ]
    }

    /// What is kept whether or not a picture is drawn.
    pub(crate) fn of_scene(&self) -> u64 {
        let Self { points, mesh, photographs, depth_maps, large_discs, .. } = *self;
        points + mesh + photographs + depth_maps + large_discs
    }
}

/// How much of the memory each kind may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shares {
    pub(crate) photographs: u64,
    pub(crate) points: u64,
    pub(crate) depth_maps: u64,
    pub(crate) mesh: u64,
    pub(crate) large_discs: u64,
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
            large_discs: sixteenth / 8,
        }
    }
}

/// What became of an update.
#[derive(Clone, Debug, Default)]
pub struct Applied {
    /// What is not resident any more to make room, as the updates that would have dropped it.
    /// Whoever keeps account of what is resident must be told.
    pub evicted: Vec<SceneUpdate>,
    /// Photographs that are resident at a coarser level than they came with, and that level: those
    /// that made room, and the one that was refused where it is there already.
    pub coarser: Vec<(ImageId, u32)>,
    /// Whether the update itself found no room: all else is more useful. Points and meshes that it
    /// was to replace are gone, too, and among the evicted; a photograph stays as it was.
    pub refused: bool,
}

/// Bytes of a texture of one level that is `size` texels large.
pub(crate) fn of_texels(format: wgpu::TextureFormat, size: glam::UVec2, layers: u32) -> u64 {
    let (width, height) = (size.x, size.y);
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    format.theoretical_memory_footprint(size)
}

/// Bytes of a texture with all its layers and levels, without what a driver adds.
pub(crate) fn of_texture(texture: &wgpu::Texture) -> u64 {
    let level = |level| {
        let size = texture.size().mip_level_size(level, texture.dimension());
        texture.format().theoretical_memory_footprint(size)
    };
    (0..texture.mip_level_count()).map(level).sum()
}

//! What can go wrong between scene updates and a frame.

use flaneur_scene::{ImageId, PointNodeId, TileKey};
use glam::UVec2;

/// Why an update was refused or a frame could not be drawn. A refused update leaves what
/// is resident as it was, unless the device failed, see [`RenderError::is_fatal`].
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The machine has no graphics driver that can be used.
    #[error(
        "no Vulkan, Metal or DirectX 12 adapter: install a graphics driver, or mesa-vulkan-drivers for one in software"
    )]
    NoAdapter,
    /// The driver refused to open the adapter.
    #[error(
        "adapter {adapter:?} cannot be opened ({reason}): update its driver, or install mesa-vulkan-drivers for one in software"
    )]
    Device {
        /// Name of the adapter.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The driver failed while it worked.
    #[error("the graphics driver failed: {0}")]
    Driver(String),
    /// The device gave less memory than the renderer may take. What was being changed is lost: the
    /// renderer cannot be used any more.
    #[error(
        "the graphics device has no memory left: allow the renderer less of it (--gpu-memory), or end other programs that use it"
    )]
    DeviceMemory,
    /// The picture asked for is empty or too large.
    #[error(
        "a picture of {}x{} pixels cannot be rendered: sides must be 1 to {max_side} and their product at most {max_pixels}",
        size.x,
        size.y
    )]
    ViewSize {
        /// The size asked for.
        size: UVec2,
        /// Longest side allowed.
        max_side: u32,
        /// Most pixels allowed.
        max_pixels: u64,
    },
    /// The view's camera is no camera.
    #[error("the view has no usable camera: {what}")]
    ViewCamera {
        /// What is wrong with it.
        what: &'static str,
    },
    /// A tile of mesh contradicts itself.
    #[error("mesh tile {key:?}: triangle index {index} is out of range of {vertices} vertices")]
    MeshIndex {
        /// The tile.
        key: TileKey,
        /// The offending index, or the number of indices where it is no multiple of three.
        index: u32,
        /// Vertices in the tile.
        vertices: usize,
    },
    /// A tile of mesh is larger than the device takes in one piece.
    #[error(
        "mesh tile {key:?}: {bytes} bytes exceed the device's limit of {limit}: send smaller tiles"
    )]
    MeshSize {
        /// The tile.
        key: TileKey,
        /// Bytes it needs.
        bytes: u64,
        /// Bytes a buffer may have.
        limit: u64,
    },
    /// The columns of a point chunk differ in length.
    #[error("points {id:?}: {length} {column} for {positions} positions")]
    PointColumns {
        /// The chunk.
        id: PointNodeId,
        /// Positions in it.
        positions: usize,
        /// The column that differs.
        column: &'static str,
        /// Its length.
        length: usize,
    },
    /// The distance between a chunk's points, or its origin, is no number.
    #[error(
        "points {id:?}: origin and spacing must be finite and the spacing positive, found {spacing_m} m"
    )]
    PointSpacing {
        /// The chunk.
        id: PointNodeId,
        /// The spacing found.
        spacing_m: f32,
    },
    /// A point chunk says of a point that it was taken from a place that it does not name.
    #[error(
        "points {id:?}: all of the {places} places they were taken from must be finite, and points name one of those"
    )]
    PointStations {
        /// The chunk.
        id: PointNodeId,
        /// Places in it.
        places: usize,
    },
    /// A photograph contradicts itself.
    #[error("image {id}: {what}")]
    Image {
        /// The photograph.
        id: ImageId,
        /// What is wrong with it.
        what: String,
    },
    /// The picture does not fit into the device's memory beside the scene.
    #[error(
        "the picture needs {needed} bytes beside the scene's {held}, of {most}: render a smaller one, or allow more device memory"
    )]
    ViewMemory {
        /// Bytes that the picture needs.
        needed: u64,
        /// Bytes that the scene holds.
        held: u64,
        /// Bytes allowed in all.
        most: u64,
    },
}

impl RenderError {
    /// Whether it is the device that failed: its renderers cannot be used any more.
    pub fn is_fatal(&self) -> bool {
        matches!(self, Self::Driver(_) | Self::DeviceMemory)
    }
}

//! Triangles ready for a renderer.

use glam::DVec3;

/// What a surface is, as far as the geometry says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum SurfaceClass {
    /// Terrain.
    Ground = 0,
    /// A wall of a building.
    Wall = 1,
    /// A roof of a building.
    Roof = 2,
}

/// Which layer a tile of mesh belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TileLayer {
    /// Extruded buildings.
    Footprints,
    /// Terrain.
    Ground,
}

/// Identity of a tile of mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileKey {
    /// The layer.
    pub layer: TileLayer,
    /// Column in the layer's grid.
    pub x: i32,
    /// Row in the layer's grid.
    pub y: i32,
}

/// A vertex of a flat-shaded triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshVertex {
    /// Position relative to the tile's origin, metres.
    pub position: [f32; 3],
    /// Outward unit normal.
    pub normal: [f32; 3],
    /// How far the surface may be from here, metres (the δ of the hybrid rule).
    pub uncertainty_m: f32,
    /// What the surface is.
    pub class: SurfaceClass,
}

/// A tile of triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshTile {
    /// Identity: a tile replaces the resident tile with the same key.
    pub key: TileKey,
    /// World position of the local origin.
    pub origin: DVec3,
    /// Vertices.
    pub vertices: Vec<MeshVertex>,
    /// Three indices a triangle.
    pub indices: Vec<u32>,
}

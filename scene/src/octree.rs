//! The octree of a point source, with the addresses that COPC gives its nodes.

use glam::{DVec3, UVec3};
use serde::{Deserialize, Serialize};

use crate::Bounds3;

/// Address of a node: level 0 is the root, x, y, z count cells of the level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct NodeKey {
    /// Depth, 0 to 30.
    pub level: u32,
    /// Cell along x, below 2^level.
    pub x: u32,
    /// Cell along y, below 2^level.
    pub y: u32,
    /// Cell along z, below 2^level.
    pub z: u32,
}

/// A node that holds points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Address.
    pub key: NodeKey,
    /// Points in this node alone, without its descendants.
    pub point_count: u32,
    /// Bytes of its compressed chunk.
    pub byte_size: u32,
    /// CRC-32 of its compressed chunk; 0 where it has none.
    pub crc32: u32,
}

/// The cube that the root fills.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OctreeCube {
    /// Its centre, world frame.
    pub centre: DVec3,
    /// Half the length of its edge, metres.
    pub half_size_m: f64,
    /// Spacing of points at the root, metres; halves with each level.
    pub spacing_m: f64,
}

impl NodeKey {
    /// The deepest level that an address can name.
    pub const MAX_LEVEL: u32 = 30;

    /// The root.
    pub const ROOT: Self = Self { level: 0, x: 0, y: 0, z: 0 };

    /// The key, or `None` where the level or a cell is out of range.
    pub fn new_checked(level: u32, x: u32, y: u32, z: u32) -> Option<Self> {
        let cells = 1u32.checked_shl(level).filter(|_| level <= Self::MAX_LEVEL)?;
        (x < cells && y < cells && z < cells).then_some(Self { level, x, y, z })
    }

    /// The node above, `None` for the root.
    pub fn parent(&self) -> Option<Self> {
        let level = self.level.checked_sub(1)?;
        Some(Self { level, x: self.x / 2, y: self.y / 2, z: self.z / 2 })
    }

    /// The eight nodes below.
    pub fn children(&self) -> [Self; 8] {
        std::array::from_fn(|i| {
            let bit = |shift: usize| u32::from((i >> shift) & 1 == 1);
            Self {
                level: self.level + 1,
                x: 2 * self.x + bit(0),
                y: 2 * self.y + bit(1),
                z: 2 * self.z + bit(2),
            }
        })
    }
}

impl OctreeCube {
    /// The box of a node, world frame.
    pub fn node_bounds(&self, key: NodeKey) -> Bounds3 {
        let edge = 2.0 * self.half_size_m / f64::from(key.level).exp2();
        let corner = self.centre - self.half_size_m;
        let min = corner + UVec3::new(key.x, key.y, key.z).as_dvec3() * edge;
        Bounds3 { min, max: min + edge }
    }

    /// Spacing of points at a level, metres.
    pub fn level_spacing_m(&self, level: u32) -> f64 {
        self.spacing_m / f64::from(level).exp2()
    }
}

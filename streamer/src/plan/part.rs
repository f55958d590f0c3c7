//! What is fetched, piece by piece.

use std::sync::Arc;

use flaneur_scene::{ImageId, PointNodeId, TileKey};

use crate::choose::District;

/// Something that is fetched whole, or not at all. Equal parts are equal bytes.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Part {
    /// The panoramas of a district: what photographs there are.
    Panoramas(District),
    /// A page of a point hierarchy: what nodes there are.
    Page(PointNodeId),
    /// Where a point source was taken from, by its index.
    Stations(u16),
    /// A mask, by its name.
    Mask(Arc<str>),
    /// A tile of mesh, of terrain every so many nodes.
    Mesh {
        /// Which tile.
        key: TileKey,
        /// 1 for buildings.
        step: u32,
    },
    /// A stored image at one of its levels.
    Image {
        /// The panorama.
        panorama: Arc<str>,
        /// Index of the camera among the panorama's.
        camera: u16,
        /// The level.
        level: u32,
    },
    /// The points of a node.
    Node(PointNodeId),
}

impl Part {
    /// Whether it says what there is, rather than being shown itself.
    pub(crate) fn is_survey(&self) -> bool {
        match self {
            Self::Panoramas(_) | Self::Page(_) | Self::Stations(_) | Self::Mask(_) => true,
            Self::Mesh { .. } | Self::Image { .. } | Self::Node(_) => false,
        }
    }

    /// Whether it may share a request with `other`.
    pub(super) fn goes_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Panoramas(_), Self::Panoramas(_))
            | (Self::Mask(_), Self::Mask(_))
            | (Self::Image { .. }, Self::Image { .. }) => true,
            (Self::Mesh { key: a, step: s }, Self::Mesh { key: b, step: t }) => {
                a.layer == b.layer && s == t
            }
            (Self::Node(a), Self::Node(b)) => a.source == b.source,
            _ => false,
        }
    }

    /// Its cell, where requests ask for a rectangle of cells.
    pub(crate) fn cell(&self) -> Option<(i32, i32)> {
        match self {
            Self::Panoramas(district) => Some(*district),
            Self::Mesh { key, .. } => Some((key.x, key.y)),
            _ => None,
        }
    }
}

/// When something is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stage {
    /// For a complete picture, however coarse.
    First,
    /// For the picture that the view asks for.
    Detail,
    /// For the view that is about to come.
    Ahead,
}

/// A part that a view wants.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Want {
    /// The part.
    pub(crate) part: Part,
    /// When.
    pub(crate) stage: Stage,
    /// Bytes, as far as they are known beforehand.
    pub(crate) bytes: u64,
    /// By how much it lowers the expected error of the picture, see [`super::order`].
    pub(crate) gain: f64,
    /// From the eye, metres.
    pub(crate) distance_m: f64,
    /// Of an image, the photographs that it gives.
    pub(crate) photographs: Arc<[ImageId]>,
    /// Whether nothing finer will do instead.
    pub(crate) exact: bool,
}

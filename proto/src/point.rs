//! Octree addresses and nodes.

use flaneur_scene::{Node, NodeKey};

use crate::error::{FieldError, required};
use crate::v1;

impl From<NodeKey> for v1::NodeKey {
    fn from(key: NodeKey) -> Self {
        Self { level: key.level, x: key.x, y: key.y, z: key.z }
    }
}

impl TryFrom<v1::NodeKey> for NodeKey {
    type Error = FieldError;

    fn try_from(key: v1::NodeKey) -> Result<Self, FieldError> {
        let v1::NodeKey { level, x, y, z } = key;
        if level > Self::MAX_LEVEL {
            return Err(FieldError::new(
                "level",
                format!("is {level}, must be 0 to {}", Self::MAX_LEVEL),
            ));
        }
        Self::new_checked(level, x, y, z).ok_or_else(|| {
            let (field, cell) = [("x", x), ("y", y), ("z", z)]
                .into_iter()
                .find(|(_, cell)| *cell >= 1 << level)
                .unwrap_or(("x", x));
            FieldError::new(field, format!("is {cell}, must be below 2^{level}"))
        })
    }
}

impl From<Node> for v1::HierarchyEntry {
    /// A node that holds points.
    fn from(node: Node) -> Self {
        Self {
            key: Some(node.key.into()),
            point_count: node.point_count,
            byte_size: node.byte_size,
            is_page: false,
            crc32: node.crc32,
        }
    }
}

impl TryFrom<v1::HierarchyEntry> for Node {
    type Error = FieldError;

    /// Meant for entries that are not pages; a node without points has no bytes.
    fn try_from(entry: v1::HierarchyEntry) -> Result<Self, FieldError> {
        let key = NodeKey::try_from(required("key", entry.key)?).map_err(|e| e.within("key"))?;
        if (entry.point_count == 0) != (entry.byte_size == 0) {
            return Err(FieldError::new(
                "byte_size",
                format!("is {} for {} points", entry.byte_size, entry.point_count),
            ));
        }
        let v1::HierarchyEntry { point_count, byte_size, crc32, .. } = entry;
        Ok(Self { key, point_count, byte_size, crc32 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn keys_out_of_range_name_the_coordinate() {
        let field = |level, x, y, z| {
            NodeKey::try_from(v1::NodeKey { level, x, y, z }).expect_err("out of range").field
        };
        assert_eq!(field(31, 0, 0, 0), "level");
        assert_eq!(field(u32::MAX, 0, 0, 0), "level");
        assert_eq!(field(0, 0, 1, 0), "y");
        assert_eq!(field(30, 0, 0, 1 << 30), "z");
    }

    #[test]
    fn a_node_has_bytes_exactly_when_it_has_points() {
        let entry = |point_count, byte_size| v1::HierarchyEntry {
            key: Some(NodeKey::ROOT.into()),
            point_count,
            byte_size,
            is_page: false,
            crc32: 0,
        };
        assert!(Node::try_from(entry(0, 0)).is_ok() && Node::try_from(entry(5, 70)).is_ok());
        assert_eq!(Node::try_from(entry(5, 0)).expect_err("no bytes").field, "byte_size");
        let keyless = v1::HierarchyEntry { key: None, ..entry(1, 1) };
        assert_eq!(Node::try_from(keyless).expect_err("no key").field, "key");
    }

    proptest! {
        #[test]
        fn keys_come_back(level in 0u32..=30, cells in prop::array::uniform3(any::<u32>())) {
            let [x, y, z] = cells.map(|cell| cell % (1 << level));
            let key = NodeKey::new_checked(level, x, y, z).expect("in range");
            prop_assert_eq!(NodeKey::try_from(v1::NodeKey::from(key)), Ok(key));
        }
    }
}

//! What is known of the octrees of a scene's point sources.

use std::collections::HashMap;

use flaneur_proto::FieldError;
use flaneur_scene::{Node, NodeKey, PointNodeId};

use crate::client::HierarchyEntry;

/// Entries of all loaded pages together.
const MAX_ENTRIES: usize = 16_000_000;
/// No such child.
const NONE: u32 = u32::MAX;

/// The parts of all sources' hierarchies that have been loaded, in an arena: going down costs no
/// look-up.
#[derive(Debug, Default)]
pub struct Hierarchy {
    cells: Vec<Cell>,
    by_id: HashMap<PointNodeId, u32>,
}

/// An entry, and where those below it are.
#[derive(Clone, Copy, Debug)]
struct Cell {
    entry: HierarchyEntry,
    children: [u32; 8],
}

/// A cell of the arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Index(u32);

impl Hierarchy {
    /// Adds the page whose root is `page`. An error names an entry outside of it.
    pub fn insert(
        &mut self,
        page: PointNodeId,
        entries: Vec<HierarchyEntry>,
    ) -> Result<(), FieldError> {
        if self.cells.len() + entries.len() >= MAX_ENTRIES {
            let problem = format!("are too many: more than {MAX_ENTRIES} in all pages");
            return Err(FieldError::new("entries", problem));
        }
        for (index, entry) in entries.iter().enumerate() {
            let (key, is_page) = key_of(entry);
            let inside = is_at_or_below(key, page.key) && !(is_page && key == page.key);
            if !inside {
                let field = format!("entries[{index}].key");
                let problem = format!("is {key:?}, outside of page {:?}", page.key);
                return Err(FieldError::new(field, problem));
            }
        }
        // A page without its own root is an empty one, and must not be asked for again.
        let empty = Node { key: page.key, point_count: 0, byte_size: 0, crc32: 0 };
        self.put(page, HierarchyEntry::Node(empty));
        for entry in entries {
            let (key, is_page) = key_of(&entry);
            let id = PointNodeId { source: page.source, key };
            // What is loaded already says more than a reference to it.
            if !is_page || !self.by_id.contains_key(&id) {
                self.put(id, entry);
            }
        }
        Ok(())
    }

    /// Where a source begins; `None` before its first page has come.
    pub(super) fn root(&self, source: u16) -> Option<Index> {
        self.by_id.get(&PointNodeId { source, key: NodeKey::ROOT }).copied().map(Index)
    }

    /// What is known of a cell.
    pub(super) fn entry(&self, index: Index) -> HierarchyEntry {
        self.cells[index.0 as usize].entry
    }

    /// The cells right below one.
    pub(super) fn children(&self, index: Index) -> impl Iterator<Item = Index> + '_ {
        let children = &self.cells[index.0 as usize].children;
        children.iter().filter(|&&child| child != NONE).map(|&child| Index(child))
    }

    fn put(&mut self, id: PointNodeId, entry: HierarchyEntry) {
        if let Some(&index) = self.by_id.get(&id) {
            self.cells[index as usize].entry = entry;
            return;
        }
        let index = self.cells.len() as u32;
        let mut children = [NONE; 8];
        if id.key.level < NodeKey::MAX_LEVEL {
            for (slot, key) in children.iter_mut().zip(id.key.children()) {
                let child = PointNodeId { key, ..id };
                *slot = self.by_id.get(&child).copied().unwrap_or(NONE);
            }
        }
        self.cells.push(Cell { entry, children });
        self.by_id.insert(id, index);
        let parent = id.key.parent().and_then(|key| self.by_id.get(&PointNodeId { key, ..id }));
        if let Some(&parent) = parent {
            let octant = (id.key.x & 1) | (id.key.y & 1) << 1 | (id.key.z & 1) << 2;
            self.cells[parent as usize].children[octant as usize] = index;
        }
    }
}

fn key_of(entry: &HierarchyEntry) -> (NodeKey, bool) {
    match entry {
        HierarchyEntry::Node(node) => (node.key, false),
        HierarchyEntry::Page(key) => (*key, true),
    }
}

pub(super) fn is_at_or_below(key: NodeKey, root: NodeKey) -> bool {
    let Some(depth) = key.level.checked_sub(root.level) else { return false };
    let above = |cell: u32| cell.checked_shr(depth).unwrap_or(0);
    (above(key.x), above(key.y), above(key.z)) == (root.x, root.y, root.z)
}
